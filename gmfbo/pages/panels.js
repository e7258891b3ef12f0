
// Switches between recordings and signals. The page is complete without it: every panel is drawn
// in the page, folded one below the other.
const curves = embedded("curves") || [];
const panels = [...document.querySelectorAll(".panel")];

const linesOf = (curve, names, column) => names.map((name) => ({
  style: curve.styles[name], words: curve.words[name], time: curve.time, values: column(name),
}));

const hold = (panel) => {
  const curve = curves[Number(panel.dataset.curve)];
  // The lower chart shows what each model leaves of the signal.
  const left = (name) => curve.values[name].map((v, i) => {
    const r = curve.values.recorded[i];
    return v === null || r === null ? null : r - v;
  });
  const whole = (name) => curve.values[name];
  const charts = [...panel.querySelectorAll(".chart")];
  enliven(panel).hold({
    charts: charts.map((chart) => chart.classList.contains("low")
      ? linesOf(curve, curve.errors, left) : linesOf(curve, curve.signals, whole)),
    read: linesOf(curve, Object.keys(curve.styles), whole),
    whole: ends(charts[0], "data-x"),
    unit: curve.unit,
  });
};

const place = document.querySelector(".panels");
const select = (chosen) => panels.forEach((panel) => { panel.hidden = panel !== chosen; });
const switcher = () => {
  const recordings = [...new Set(panels.map((panel) => panel.dataset.recording))];
  const signals = [...new Set(panels.map((panel) => panel.dataset.signal))];
  const bar = text("div", "", "switch");
  const list = document.createElement("select");
  list.setAttribute("aria-label", "recording");
  recordings.forEach((name) => {
    const first = panels.find((panel) => panel.dataset.recording === name);
    const option = text("option", [name, first.dataset.part].filter(Boolean).join(", "));
    option.value = name;
    list.append(option);
  });
  let signal = panels[0].dataset.signal;
  const update = () => {
    const own = panels.filter((panel) => panel.dataset.recording === list.value);
    select(own.find((panel) => panel.dataset.signal === signal) || own[0]);
    buttons.forEach((button) => button.setAttribute("aria-pressed", button.value === signal));
  };
  const buttons = signals.map((name) => {
    const button = text("button", name);
    button.value = name;
    button.type = "button";
    button.addEventListener("click", () => { signal = name; update(); });
    return button;
  });
  list.addEventListener("change", update);
  bar.append(list, ...buttons);
  place.prepend(bar);
  update();
};

panels.forEach((panel) => { place.append(panel); hold(panel); });
document.querySelectorAll(".more-panels").forEach((folded) => folded.remove());
if (panels.length > 1) switcher();
document.documentElement.dataset.script = "ready";
