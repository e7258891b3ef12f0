// Switches between recordings and signals, reads values off the curves, and zooms.
// The page is complete without it: every panel is drawn in the page, folded one below the other.
"use strict";
(() => {
  const WIDE = 2000, HIGH = 1000;
  const held = document.getElementById("curves");
  if (!held) return;
  const curves = JSON.parse(held.textContent);
  const panels = [...document.querySelectorAll(".panel")];
  const text = (tag, words, style) => {
    const made = document.createElement(tag);
    made.textContent = words;
    if (style) made.className = style;
    return made;
  };
  const svg = (tag, attributes) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    return made;
  };
  const ends = (element, name) => element.getAttribute(name).split(" ").map(Number);

  const ticks = (low, high) => {
    const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    const decimals = Math.min(12, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
    const largest = Math.max(...found.map(Math.abs));
    const plain = largest >= 1e-4 && largest < 1e6;
    return found.map((v) => [v, plain ? v.toFixed(decimals) : String(Number(v.toPrecision(4)))]);
  };

  // Columns of a chart: the signal itself, or what each model leaves of it.
  const column = (curve, name, error) => {
    const values = curve.values[name];
    return error ? values.map((v, i) => {
      const r = curve.values.recorded[i];
      return v === null || r === null ? null : r - v;
    }) : values;
  };

  const draw = (chart, curve, from, to) => {
    const error = chart.classList.contains("low");
    const area = chart.querySelector(".area");
    const names = error ? curve.errors : curve.signals;
    const columns = names.map((name) => column(curve, name, error));
    let low = Infinity, high = -Infinity;
    const inside = curve.time.map((t) => t >= from && t <= to);
    columns.forEach((values) => values.forEach((v, i) => {
      if (inside[i] && v !== null) { low = Math.min(low, v); high = Math.max(high, v); }
    }));
    if (!(high > low)) return;
    const margin = 0.05 * (high - low);
    low -= margin; high += margin;
    const x = (t) => WIDE * (t - from) / (to - from), y = (v) => HIGH * (high - v) / (high - low);
    names.forEach((name, k) => {
      const path = area.querySelector(".line." + curve.styles[name]);
      if (!path) return;
      let d = "", pen = "M";
      curve.time.forEach((t, i) => {
        const near = inside[i] || inside[i - 1] || inside[i + 1];
        const v = columns[k][i];
        if (!near || v === null) { pen = "M"; return; }
        d += pen + x(t).toFixed(1) + " " + y(v).toFixed(1);
        pen = "L";
      });
      path.setAttribute("d", d || "M0 0");
    });
    area.querySelectorAll(".window").forEach((window) => {
      const [start, end] = ends(window, "data-x");
      window.setAttribute("x", x(start));
      window.setAttribute("width", Math.max(6, x(end) - x(start)));
    });
    const across = ticks(low, high), along = ticks(from, to);
    area.querySelector(".grid").setAttribute("d",
      along.map(([t]) => `M${x(t)} 0V${HIGH}`).join("") + across.map(([v]) => `M0 ${y(v)}H${WIDE}`).join(""));
    const group = chart.querySelector(".ticks");
    group.replaceChildren(
      ...across.map(([v, words]) => {
        const label = svg("text", { class: "y-tick", x: -8, dy: 4, y: y(v) / HIGH * 100 + "%" });
        label.textContent = words;
        return label;
      }),
      ...(chart.classList.contains("bare") ? [] : along.map(([t, words]) => {
        const label = svg("text", { class: "x-tick", x: x(t) / WIDE * 100 + "%", y: "100%", dy: 17 });
        label.textContent = words;
        return label;
      })));
  };

  const enliven = (panel) => {
    const curve = curves[Number(panel.dataset.curve)];
    const charts = [...panel.querySelectorAll(".chart")];
    const whole = ends(charts[0], "data-x");
    let view = whole, started = null;
    const readOut = text("p", "", "read-out");
    const hint = "Point at the curves to read them; drag to zoom, double-click to see all.";
    readOut.textContent = hint;
    charts[charts.length - 1].after(readOut);
    const cursors = charts.map((chart) => {
      const cursor = svg("path", { class: "cursor", d: "", visibility: "hidden" });
      const chosen = svg("rect", { class: "chosen", y: 0, height: HIGH, visibility: "hidden" });
      chart.querySelector(".area").append(chosen, cursor);
      return [cursor, chosen];
    });
    const show = (from, to) => {
      view = [from, to];
      charts.forEach((chart) => draw(chart, curve, from, to));
    };
    const share = (event, plot) => {
      const box = plot.getBoundingClientRect();
      return Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    };
    const read = (at) => {
      const t = view[0] + at * (view[1] - view[0]);
      let row = 0, last = curve.time.length - 1;
      while (last - row > 1) {
        const middle = (row + last) >> 1;
        if (curve.time[middle] <= t) row = middle; else last = middle;
      }
      if (Math.abs(curve.time[last] - t) < Math.abs(curve.time[row] - t)) row = last;
      const told = Object.keys(curve.styles)
        .filter((name) => curve.values[name][row] !== null)
        .map((name) => `${curve.words[name]} ${Number(curve.values[name][row].toPrecision(4))}`);
      readOut.textContent = `${Number(curve.time[row].toPrecision(6))} s: ${told.join(", ")} ${curve.unit}`;
      const x = WIDE * (curve.time[row] - view[0]) / (view[1] - view[0]);
      cursors.forEach(([cursor]) => {
        cursor.setAttribute("d", `M${x} 0V${HIGH}`);
        cursor.setAttribute("visibility", "visible");
      });
    };
    charts.forEach((chart) => {
      const plot = chart.querySelector(".plot");
      plot.style.cursor = "crosshair";
      plot.style.touchAction = "pan-y";
      // Without a background the plot hears the pointer on its lines only.
      chart.querySelector(".area").prepend(svg("rect", { width: WIDE, height: HIGH, fill: "transparent" }));
      plot.addEventListener("pointerdown", (event) => {
        started = share(event, plot);
        plot.setPointerCapture(event.pointerId);
        event.preventDefault();
      });
      plot.addEventListener("pointermove", (event) => {
        const at = share(event, plot);
        read(at);
        cursors.forEach(([, chosen]) => {
          if (started === null || event.pointerType === "touch") return;
          chosen.setAttribute("x", WIDE * Math.min(at, started));
          chosen.setAttribute("width", WIDE * Math.abs(at - started));
          chosen.setAttribute("visibility", "visible");
        });
      });
      plot.addEventListener("pointerup", (event) => {
        const at = share(event, plot), begun = started;
        started = null;
        cursors.forEach(([, chosen]) => chosen.setAttribute("visibility", "hidden"));
        if (begun === null || event.pointerType === "touch" || Math.abs(at - begun) < 0.01) return;
        const wide = view[1] - view[0];
        show(view[0] + wide * Math.min(at, begun), view[0] + wide * Math.max(at, begun));
      });
      plot.addEventListener("pointerleave", () => {
        if (started !== null) return;
        readOut.textContent = hint;
        cursors.forEach(([cursor]) => cursor.setAttribute("visibility", "hidden"));
      });
      plot.addEventListener("dblclick", () => show(...whole));
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
      const option = text("option", `${name}, ${first.dataset.part}`);
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

  panels.forEach((panel) => { place.append(panel); enliven(panel); });
  document.querySelectorAll(".more-panels").forEach((folded) => folded.remove());
  if (panels.length > 1) switcher();
  document.documentElement.dataset.script = "ready";
})();
