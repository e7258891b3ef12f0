
// Shows the trajectories of any run: chosen by a click on a mark or a table's number, from the
// list, or by the arrow keys.
const study = embedded("study"), trajectories = embedded("trajectories");
const runs = new Map(study.runs.map((run) => [run.number, run]));
const bestWords = study.settled ? "best" : "least bad";
const NAMES = { IS1: "real", IS2: "twin", IS3: "corrected twin" };
const short = (value, digits = 4) => value === null ? "-" : String(Number(value.toPrecision(digits)));
const swatch = (style) => {
  const drawn = svg("svg", { class: "swatch", viewBox: "0 0 26 10", "aria-hidden": "true" });
  drawn.append(svg("path", { class: "line " + style, d: "M1 5H25" }));
  return drawn;
};

const column = (number, signal) => (trajectories.runs[number] || {})[signal];
const line = (style, words, held, values = held.y) => ({ style, words, time: held.t, values });

// What belongs to a run: the real one, the twin's at the same gains, the corrected ones around it.
const family = (run) => {
  const real = run.source === "IS1" ? run : runs.get(run.parent);
  const around = study.runs.filter((one) => real && one.parent === real.number);
  return {
    real,
    twin: run.source === "IS2" ? run : around.filter((one) => one.source === "IS2").pop(),
    corrected: run.source === "IS3" ? [run]
      : around.filter((one) => one.source === "IS3" && one.role === "corrected"),
  };
};

const linesOf = (run, signal) => {
  const { real, twin, corrected } = family(run), lines = [];
  const scored = signal === study.signal;
  if (scored && trajectories.reference) lines.push(line("floor", "reference", trajectories.reference));
  const add = (one, style, words) => {
    const held = one && column(one.number, signal);
    if (held && held.t.length) lines.push(line(style, words, held));
  };
  if (real) add(real, "recorded", `real run ${real.number} (IS1)`);
  if (run.source === "IS3") {
    const held = column(run.number, signal);
    if (held && held.u) lines.push(line("before", `twin before correction, run ${run.number}`, held, held.u));
  } else if (twin) add(twin, "before", `twin, run ${twin.number} (IS2)`);
  corrected.forEach((one) => {
    const held = column(one.number, signal);
    add(one, run.source === "IS3" ? "after" : "after thin", `corrected twin, run ${one.number} (IS3)`);
    const made = lines[lines.length - 1];
    // 95 % of a normal distribution.
    if (run === one && held && held.s) {
      made.low = held.y.map((y, i) => held.s[i] === null ? null : y - 1.96 * held.s[i]);
      made.high = held.y.map((y, i) => held.s[i] === null ? null : y + 1.96 * held.s[i]);
    }
  });
  return lines;
};

const panelOf = (id) => {
  const panel = document.getElementById(id);
  return panel && { panel, live: enliven(panel) };
};
const spanOf = (lines) => [
  Math.min(...lines.map((one) => one.time[0])), Math.max(...lines.map((one) => one.time[one.time.length - 1]))];
const unitOf = (signal) => (trajectories.signals.find((one) => one.name === signal) || { unit: "" }).unit;
const readable = (unit) => unit.replace(/\./g, "\u00a0").replace(/([A-Za-z])2/g, "$1²");

const responses = panelOf("responses");
if (responses) {
  const { first, best } = responses.panel.dataset;
  const lines = [line("floor", "reference", trajectories.reference || { t: [], y: [] }),
    first === best ? null : line("before", "first", column(first, study.signal)),
    line("after", bestWords, column(best, study.signal))].filter((one) => one && one.time.length);
  responses.live.hold({ charts: [lines], read: lines.slice().reverse(), whole: spanOf(lines),
    unit: readable(unitOf(study.signal)) });
}

const viewer = panelOf("viewer");
if (viewer) {
  const { panel, live } = viewer;
  const told = panel.querySelector("#told"), names = panel.querySelector(".legend");
  const chart = panel.querySelector(".chart"), order = study.runs.map((run) => run.number);
  let chosen = null, signal = study.signal;

  const bar = text("div", "", "switch");
  const list = document.createElement("select");
  list.setAttribute("aria-label", "run");
  ["IS1", "IS2", "IS3"].forEach((source) => {
    const own = study.runs.filter((run) => run.source === source);
    if (!own.length) return;
    const group = document.createElement("optgroup");
    group.label = `${NAMES[source]} (${source})`;
    own.forEach((run) => {
      const option = text("option", `run ${run.number}: ${source}, objective ${short(run.objective)}`);
      option.value = run.number;
      group.append(option);
    });
    list.append(group);
  });
  const button = (words, label, act) => {
    const made = text("button", words);
    made.type = "button";
    made.setAttribute("aria-label", label);
    made.addEventListener("click", act);
    return made;
  };
  const step = (by) => {
    const next = order[order.indexOf(chosen) + by];
    if (next !== undefined) choose(next);
  };
  const buttons = trajectories.signals.map(({ name }) =>
    button(name.replace(/_/g, " "), "signal " + name.replace(/_/g, " "), () => { signal = name; choose(chosen); }));

  const describe = (run) => {
    const gains = Object.entries(run.gains).map(([name, value]) => `${name} = ${short(value)}`);
    const metrics = Object.entries(run.metrics).filter(([name]) => name in study.metrics)
      .map(([name, value]) => `${name.replace(/_/g, " ")} `
        + (run.never[name] || `${short(value)} ${study.metrics[name]}`.trim())
        + (study.from_the_twin.includes(name) ? " (from the twin)" : ""));
    const early = run.status === "ok" ? "" : `, ${run.status}`;
    const ended = run.status === "ok" && !run.settled ? ", not settled" : early;
    const best = run.number === study.best ? `, the ${bestWords}` : "";
    told.replaceChildren(text("b", `Run ${run.number}`),
      ` ${NAMES[run.source]} (${run.source})${best}${ended}: ${gains.join(", ")}; `,
      text("b", `objective ${short(run.objective)}`), `; ${metrics.join(", ")}`);
  };

  const choose = (number) => {
    const run = runs.get(number);
    if (!run) return;
    chosen = number;
    list.value = number;
    describe(run);
    let lines = linesOf(run, signal);
    if (!lines.some((one) => one.style !== "floor")) {
      // Corrected runs have the signal of the objective alone.
      signal = study.signal;
      lines = linesOf(run, signal);
    }
    buttons.forEach((one, k) => one.setAttribute("aria-pressed", trajectories.signals[k].name === signal));
    const kinds = new Map();
    lines.forEach((one) => kinds.set(one.style, kinds.has(one.style) ? "corrected twin, nearby (IS3)" : one.words));
    names.replaceChildren(...[...kinds].map(([style, words]) => {
      const entry = text("li", "");
      entry.append(swatch(style), words);
      return entry;
    }));
    const unit = readable(unitOf(signal));
    chart.querySelector(".y-label").textContent = signal.replace(/_/g, " ") + (unit ? ` [${unit}]` : "");
    chart.querySelector(".plot").setAttribute("aria-label",
      `${signal.replace(/_/g, " ")} over time: ${lines.map((one) => one.words).join(", ")}`);
    document.querySelectorAll(".mark.shown").forEach((mark) => mark.classList.remove("shown"));
    document.querySelectorAll(`.mark[data-run="${number}"]`).forEach((mark) => mark.classList.add("shown"));
    if (!lines.length) return;
    live.hold({ charts: [lines], read: lines.slice().reverse(), whole: spanOf(lines), unit });
    live.draw();
  };

  list.addEventListener("change", () => choose(Number(list.value)));
  bar.append(button("‹", "previous run", () => step(-1)), list, button("›", "next run", () => step(1)));
  if (buttons.length > 1) bar.append(...buttons);
  panel.prepend(bar);
  panel.tabIndex = 0;
  panel.setAttribute("aria-label", "trajectories of a run; left and right arrow keys choose another");
  panel.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by || event.target === list) return;
    event.preventDefault();
    step(by);
  });
  document.addEventListener("click", (event) => {
    const mark = event.target.closest("[data-run]");
    if (!mark) return;
    choose(Number(mark.dataset.run));
    if (mark.tagName === "BUTTON") panel.scrollIntoView({ block: "center" });
  });
  panel.hidden = false;
  choose(study.best === null ? order[order.length - 1] : study.best);
}

// What lies under the pointer is told below the map.
const map = document.querySelector("figure.gains");
if (map) {
  const below = text("p", "Click a run to see its trajectories.", "read-out"), hint = below.textContent;
  map.append(below);
  map.addEventListener("pointermove", (event) => {
    const mark = event.target.closest(".mark");
    const run = mark && runs.get(Number(mark.dataset.run));
    below.textContent = run
      ? `run ${run.number} (${run.source}): objective ${short(run.objective)} at ` +
        Object.entries(run.gains).map(([name, value]) => `${name} = ${short(value)}`).join(", ") : hint;
  });
}

// Two lists choose which pair of metrics is drawn.
const offs = document.getElementById("trade-offs");
if (offs) {
  const figures = [...offs.querySelectorAll("figure")];
  const named = [...new Set(figures.flatMap((one) => [one.dataset.x, one.dataset.y]))];
  const listOf = (label, picked) => {
    const list = document.createElement("select");
    list.setAttribute("aria-label", label);
    named.forEach((name) => {
      const option = text("option", name.replace(/_/g, " "));
      option.value = name;
      option.selected = name === picked;
      list.append(option);
    });
    return list;
  };
  const first = listOf("one metric", figures[0].dataset.x);
  const second = listOf("the other metric", figures[0].dataset.y);
  const show = (changed, other) => {
    if (changed.value === other.value) other.value = named.find((name) => name !== changed.value);
    const pair = [first.value, second.value];
    figures.forEach((one) => {
      one.hidden = !(pair.includes(one.dataset.x) && pair.includes(one.dataset.y));
    });
  };
  first.addEventListener("change", () => show(first, second));
  second.addEventListener("change", () => show(second, first));
  const bar = text("div", "", "switch");
  bar.append(first, second);
  offs.prepend(bar);
}
document.documentElement.dataset.script = "ready";
