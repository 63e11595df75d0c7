// A slider of the browser's own: it has a name for screen readers, and tells its value while it moves.
export function render({ model }) {
  const label = document.createElement("label");
  const words = document.createElement("span");
  const shown = document.createElement("output");
  const input = document.createElement("input");
  input.type = "range";
  input.setAttribute("aria-label", model.label);
  words.append(model.label, " ", shown);
  label.append(words, input);
  const show = () => {
    const said = String(Number((model.value / model.scale).toPrecision(4)));
    shown.textContent = said;
    input.setAttribute("aria-valuetext", said);
  };
  const set = () => {
    [input.min, input.max, input.step] = [model.start, model.end, "any"];
    input.value = model.value;
    show();
  };
  // arrow keys move by a step, whatever the value is
  input.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (!by) return;
    event.preventDefault();
    model.value = Math.min(model.end, Math.max(model.start, model.value + by * model.step));
  });
  input.addEventListener("input", () => { model.value = Number(input.value); });
  model.on("value", set);
  set();
  return label;
}
