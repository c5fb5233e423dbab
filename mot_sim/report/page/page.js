"use strict";
(() => {
  const plots = JSON.parse(document.getElementById("plots").textContent);
  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const options = { displaylogo: false, responsive: true, modeBarButtonsToRemove: [
    "select2d", "lasso2d", "autoScale2d", "zoomIn2d", "zoomOut2d",
  ] };

  // On dark paper the blue of the palette is too dark to be seen.
  const isDark = matchMedia("(prefers-color-scheme: dark)");
  const traces = (data) => {
    const text = JSON.stringify(data);
    return JSON.parse(isDark.matches ? text.replaceAll("#0072b2", "#4aa3dc") : text);
  };

  // The page's own colours for a chart; axes keep what the chart says of them.
  const themed = (layout) => {
    const ink = colour("--ink"), grid = colour("--grid"), paper = colour("--paper");
    const axis = (own) => ({
      ...own, gridcolor: grid, zerolinecolor: grid, linecolor: colour("--faint"), showline: true,
    });
    return {
      ...layout, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: "system-ui, sans-serif", size: 13, color: ink },
      hoverlabel: { bgcolor: paper, bordercolor: grid, font: { color: ink, size: 13 } },
      xaxis: axis(layout.xaxis), yaxis: axis(layout.yaxis),
    };
  };

  const draw = (panel) => {
    const chart = plots[panel.dataset.panel][panel.querySelector("select")?.value ?? 0];
    const layout = themed(JSON.parse(JSON.stringify(chart.plot.layout)));
    const place = panel.querySelector(".plot");
    place.setAttribute("aria-label", chart.about);
    panel.classList.add("drawn");
    return Plotly.react(place, traces(chart.plot.data), layout, options);
  };

  // Where a panel has several charts: a list to choose from. The other panels of the result
  // follow, so that one looks at the same score over every axis.
  const chooser = (panel, charts) => {
    const label = document.createElement("label"), list = document.createElement("select");
    charts.forEach((chart, number) => list.add(new Option(chart.label, number)));
    list.addEventListener("change", () => {
      const wanted = list.selectedOptions[0].text;
      for (const each of panel.closest(".charts").querySelectorAll("figure.panel")) {
        const other = each.querySelector("select");
        const same = [...(other?.options ?? [])].find((option) => option.text === wanted);
        if (same === undefined) continue;
        other.value = same.value;
        if (each.classList.contains("drawn")) draw(each);
      }
    });
    label.append("Show ", list);
    panel.querySelector(".panel-head").append(label);
  };

  const panels = [...document.querySelectorAll("figure.panel")];
  // Charts are drawn as they come near the window: a long page opens as fast as a short one.
  const near = new IntersectionObserver((seen) => {
    for (const each of seen.filter((one) => one.isIntersecting)) {
      near.unobserve(each.target);
      draw(each.target);
    }
  }, { rootMargin: "400px" });
  const begin = () => {
    const script = document.createElement("script");
    script.textContent = document.getElementById("library").textContent;
    document.head.append(script);
    for (const panel of panels) {
      const charts = plots[panel.dataset.panel];
      if (charts.length > 1) chooser(panel, charts);
      near.observe(panel);
    }
  };
  // The library takes longer to start than all the rest: first the page stands there, with still
  // pictures of the charts, and then the charts come.
  addEventListener("load", () => setTimeout(begin, 50));
  const redraw = () => panels.filter((each) => each.classList.contains("drawn")).forEach(draw);
  isDark.addEventListener("change", redraw);
})();
