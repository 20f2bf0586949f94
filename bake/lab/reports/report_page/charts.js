// Error curves: one chart per measure, all with the same methods and the same cursor.

const charts = [];

// Draws each visible method's marker at its points, best last so that it lies on top.
function drawMarkers(chart) {
  const {ctx} = chart;
  const size = 3.6 * devicePixelRatio;
  for (let index = methods.length; index >= 1; --index) {
    if (!chart.series[index].show) continue;
    const path = new Path2D(methods[index - 1].shape);
    ctx.fillStyle = color(methods[index - 1]);
    chart.data[index].forEach((value, point) => {
      if (value === null) return;
      ctx.save();
      ctx.translate(chart.valToPos(chart.data[0][point], 'x', true), chart.valToPos(value, 'y', true));
      ctx.scale(size, size);
      ctx.fill(path);
      ctx.restore();
    });
  }
}

function drawLineAtOne(chart) {
  const {ctx, bbox} = chart;
  const y = Math.round(chart.valToPos(1, 'y', true));
  ctx.save();
  ctx.strokeStyle = ink('--muted');
  ctx.setLineDash([4, 4]);
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
}

const ink = name => getComputedStyle(document.documentElement).getPropertyValue(name);

// A box beside the cursor: the level and every visible method's figure, best first.
function showTooltip(chart, box, measure) {
  const point = chart.cursor.idx;
  const hovered = point !== null && point !== undefined && chart.over.matches(':hover');
  box.hidden = !hovered;
  if (!hovered) return;
  const level = ascending[point];
  const rows = methods.filter(method => method.visible)
    .map(method => ({method, value: method.levels[level.index][measure.key]}))
    .sort((a, b) => badness(a.value, measure) - badness(b.value, measure));
  box.replaceChildren(element('strong', {}, `${percent(level.fraction)}: ${count(level.leaves)} leaves`),
    element('table', {}, ...rows.map(({method, value}) =>
      element('tr', {}, element('td', {}, label(method)), element('td', {}, figure(value, measure))))));
  const x = chart.valToPos(level.leaves, 'x');
  const left = x > chart.over.clientWidth / 2 ? x - box.offsetWidth - 12 : x + 12;
  box.style.transform = `translate(${Math.max(left, -chart.over.offsetLeft)}px, 4px)`;
}

// From the finest level on, leaves out labels that would touch the one before.
function sparse(chart, splits) {
  let last = -Infinity;
  return [...splits].reverse().map(split => {
    const x = chart.valToPos(split, 'x');
    if (x - last < 32) return null;
    last = x;
    return split;
  }).reverse();
}

const ascending = [...levels].reverse();
const leafRange = () => [ascending[0].leaves / 1.12, ascending.at(-1).leaves * 1.12];

function valueRange(measure) {
  return (chart, low, high) => {
    if (low === null || high === null) return [0, 1];
    if (measure.better !== 'one') return [0, high > 0 ? 1.06 * high : 1];
    const reach = Math.max(1 - low, high - 1, 0.02) * 1.1;
    return [Math.max(0, low < 1 ? 1 - reach : 1 - 0.2 * reach), high > 1 ? 1 + reach : 1 + 0.2 * reach];
  };
}

function chartOptions(measure, width, box) {
  const axis = {stroke: () => ink('--muted'), grid: {stroke: () => ink('--grid'), width: 1}, ticks: {show: false}, font: '12px system-ui, sans-serif'};
  const draw = [drawMarkers];
  if (measure.better === 'one') draw.unshift(drawLineAtOne);
  return {
    width,
    height: 230,
    legend: {show: false},
    scales: {x: {time: false, distr: 3, dir: -1, range: leafRange}, y: {range: valueRange(measure)}},
    axes: [
      {...axis, size: 28, splits: () => ascending.map(level => level.leaves), filter: sparse,
        values: (chart, splits) => splits.map(split => split === null ? null : percent(levels.find(level => level.leaves === split).fraction))},
      {...axis, size: 52, space: 34},
    ],
    series: [{}, ...methods.map(method => ({
      label: method.name, stroke: () => color(method), width: method.name === 'default' ? 3 : 1.6, dash: method.dash, points: {show: false}}))],
    cursor: {sync: {key: 'levels'}, y: false, drag: {x: false, y: false}, points: {show: false}},
    hooks: {draw, setCursor: [chart => showTooltip(chart, box, measure)]},
  };
}

function describe(measure) {
  return methods.map(method => `${method.name} ${levels.map(level => figure(method.levels[level.index][measure.key], measure)).join(', ')}`).join('; ');
}

function makeChart(key) {
  const measure = measureOf(key);
  const plot = element('div', {className: 'plot', role: 'img', ariaLabel: `${measure.title} by level, ${levels.map(level => percent(level.fraction)).join(', ')}: ${describe(measure)}`});
  const holder = element('figure', {className: 'card'}, element('figcaption', {}, element('h3', {}, measure.title), element('p', {}, measure.note)), plot);
  document.getElementById('charts').append(holder);
  const box = element('div', {className: 'tooltip', hidden: true});
  const columns = [ascending.map(level => level.leaves), ...methods.map(method => ascending.map(level => method.levels[level.index][key]))];
  const chart = new uPlot(chartOptions(measure, plot.clientWidth, box), columns, plot);
  chart.over.append(box);
  chart.over.addEventListener('mouseleave', () => { box.hidden = true; });
  new ResizeObserver(() => {
    if (plot.clientWidth !== chart.width) chart.setSize({width: plot.clientWidth, height: chart.height});
  }).observe(plot);
  charts.push(chart);
}

function makeLegend() {
  const legend = document.getElementById('legend');
  methods.forEach((method, index) => {
    const button = element('button', {type: 'button', title: aboutMethod(method)}, label(method));
    button.setAttribute('aria-pressed', 'true');
    button.addEventListener('click', () => {
      method.visible = !method.visible;
      button.setAttribute('aria-pressed', String(method.visible));
      for (const chart of charts) chart.setSeries(index + 1, {show: method.visible});
    });
    legend.append(button);
  });
}

function makeCharts() {
  makeLegend();
  chartKeys.forEach(makeChart);
}
