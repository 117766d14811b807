// Draw every diagram of the page, keep the time axes together, follow light and dark, fit the printer.
"use strict";
(() => {
  // The buttons are listed, and the server left empty: plotly's own set has one that uploads the data.
  const config = {
    responsive: true, displaylogo: false, plotlyServerURL: "", toImageButtonOptions: {format: "svg"},
    modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
  };
  const plots = [];
  const ink = () => getComputedStyle(document.documentElement).getPropertyValue("--ink").trim();
  const paper = () => getComputedStyle(document.documentElement).getPropertyValue("--paper").trim();
  const theme = () => ({"font.color": ink(), "hoverlabel.bgcolor": paper(), "hoverlabel.font.color": ink()});

  for (const source of document.querySelectorAll("script[data-plot]")) {
    const plot = document.getElementById(source.dataset.plot);
    const {data, layout} = JSON.parse(source.textContent);
    layout.font.color = ink();
    layout.hoverlabel = {bgcolor: paper(), font: {color: ink()}};
    Plotly.newPlot(plot, data, layout, config);
    plots.push(plot);
  }

  const linked = plots.filter((plot) => "linked" in plot.dataset);
  let busy = false;
  for (const plot of linked) {
    plot.on("plotly_relayout", (event) => {
      if (busy || !Object.keys(event).some((key) => key.startsWith("xaxis"))) return;
      busy = true;
      const range = [...plot.layout.xaxis.range];
      const others = linked.filter((other) => other !== plot);
      Promise.all(others.map((other) => Plotly.relayout(other, {"xaxis.range": [...range]})))
        .finally(() => { busy = false; });
    });
  }

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const plot of plots) Plotly.relayout(plot, theme());
  });
  addEventListener("beforeprint", () => {
    for (const plot of plots) Plotly.relayout(plot, {...theme(), width: 680, autosize: false});
  });
  addEventListener("afterprint", () => {
    for (const plot of plots) Plotly.relayout(plot, {...theme(), width: null, autosize: true});
  });
})();
