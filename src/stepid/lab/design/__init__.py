"""Design before the lab: which runs determine a guessed plant as well as wanted, and tell two effects apart."""
