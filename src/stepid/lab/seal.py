"""Close a text with a passphrase, and open it again, with nothing but the standard library.

scrypt makes three values from the passphrase and a fresh salt: the key of a SHAKE-256 keystream that is added to the
text, the key of an HMAC-SHA256 over all of the file, and a sign that tells a wrong passphrase from a changed file.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import os
import unicodedata

from stepid.core.takes import described
from stepid.errors import InputError

FORMAT = "stepid sealed answers 1"
FEWEST = 8  # letters of a passphrase
_COST = {"n": 2**15, "r": 8, "p": 1}  # scrypt: 32 MB and about 0.1 s a try
_BYTES = 32


def _keys(passphrase: str, salt: bytes) -> tuple[bytes, bytes, bytes]:
    text = unicodedata.normalize("NFC", passphrase).encode("utf-8", "surrogatepass")
    found = hashlib.scrypt(text, salt=salt, dklen=3 * _BYTES, maxmem=2**26, **_COST)
    return found[:_BYTES], found[_BYTES : 2 * _BYTES], found[2 * _BYTES :]


def _stream(key: bytes, text: bytes) -> bytes:
    return bytes(a ^ b for a, b in zip(text, hashlib.shake_256(key).digest(len(text)), strict=True))


def _tag(key: bytes, salt: bytes, sign: bytes, body: bytes) -> bytes:
    return hmac.digest(key, FORMAT.encode() + salt + sign + body, "sha256")


def seal(text: str, *, passphrase: str, padded: int) -> str:
    """Close a text.

    Parameters
    ----------
    text : str
    passphrase : str
        At least 8 characters.
    padded : int
        The text is filled with blanks to a multiple of so many bytes, so that its length tells nothing.

    Returns
    -------
    str
        JSON, to be kept in a file.

    Raises
    ------
    stepid.errors.InputError
        If the passphrase is too short.
    """
    if not isinstance(passphrase, str) or len(passphrase) < FEWEST:
        raise InputError(
            f"the passphrase is shorter than {FEWEST} characters", "Take several words that students will not guess."
        )
    plain = text.encode()
    plain += b" " * (-len(plain) % padded)
    salt = os.urandom(16)
    cipher, check, sign = _keys(passphrase, salt)
    body = _stream(cipher, plain)
    parts = {"salt": salt, "sign": sign, "tag": _tag(check, salt, sign, body), "body": body}
    return json.dumps({"format": FORMAT} | {k: base64.b64encode(v).decode() for k, v in parts.items()}, indent=1) + "\n"


def unseal(sealed: bytes, *, passphrase: str, where: str) -> str:
    """Open what `seal` has closed.

    Parameters
    ----------
    sealed : bytes
        Content of the file.
    passphrase : str
    where : str
        Names the file in errors.

    Returns
    -------
    str

    Raises
    ------
    stepid.errors.InputError
        If the passphrase is wrong, or the file is cut off, changed or something else.
    """
    salt, sign, tag, body = _parts(sealed, where)
    if not isinstance(passphrase, str):
        raise InputError(
            f"{where}: the passphrase is {described(passphrase)}", "Give the text that the answers were sealed with."
        )
    cipher, check, expected = _keys(passphrase, salt)
    if not hmac.compare_digest(expected, sign):
        raise InputError(f"{where}: the passphrase is wrong", "Give the one that the answers were sealed with.")
    if not hmac.compare_digest(_tag(check, salt, sign, body), tag):
        raise InputError(
            f"{where}: has been changed since it was sealed", "Restore it, or make the assignment again from its seed."
        )
    return _stream(cipher, body).decode()


def _parts(sealed: bytes, where: str) -> tuple[bytes, bytes, bytes, bytes]:
    try:
        values = json.loads(sealed)
        if values["format"] != FORMAT:
            raise InputError(f"{where}: its format is {values['format']!r}", f"This version opens {FORMAT!r}.")
        salt, sign, tag, body = (base64.b64decode(values[k], validate=True) for k in ("salt", "sign", "tag", "body"))
    except InputError:
        raise
    except (ValueError, KeyError, TypeError):
        raise InputError(
            f"{where}: is not a whole file of sealed answers", "Copy it again; it may be cut off, or another file."
        ) from None
    return salt, sign, tag, body
