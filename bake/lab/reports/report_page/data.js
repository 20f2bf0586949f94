'use strict';
// What the page shows: the evaluation's figures, and how measures and methods are named and drawn. All files of report_page/ are one script.

const data = JSON.parse(document.getElementById('data').textContent);

// Names of the three image errors, and the sizes of their pictures.
const rmse = data.rmse;
const sizes = [1, 4, 16].map(factor => `${data.size_px / factor} x ${data.size_px / factor}`);

// better: 'low' marks the lowest of a row, 'one' the nearest to 1, 'high' the highest.
const measures = [
  {key: rmse[0], title: 'Image error close up', digits: 2, better: 'low', note: `${rmse[0]}: difference of pictures ${sizes[0]}. Lower is better.`},
  {key: rmse[1], title: 'Image error farther away', digits: 2, better: 'low', note: `${rmse[1]}: the same pictures shrunk to ${sizes[1]}. Lower is better.`},
  {key: rmse[2], title: 'Image error in the distance', digits: 2, better: 'low', note: `${rmse[2]}: shrunk to ${sizes[2]}, where only mass and tone count. Lower is better.`},
  {key: 'hausdorff', title: 'Largest surface distance', digits: 4, better: 'low', note: 'Hausdorff: how far the farthest point has moved. Lower is better.'},
  {key: 'coverage', title: 'Coverage', digits: 3, better: 'one', note: 'Pixels that show foliage, over the source\'s. 1 keeps the crown as dense as it was.'},
  {key: 'mean_distance', title: 'Mean surface distance', digits: 5, better: 'low', note: 'How far the average point has moved. Lower is better.'},
  {key: 'soft_iou', title: 'Overlap of silhouettes', digits: 3, better: 'high', note: `Soft intersection over union of coverage at ${sizes[1]}. Higher is better.`},
  {key: 'area_ratio', title: 'Leaf area', digits: 3, better: 'one', note: 'Area of all leaves, over the source\'s.'},
];
// Errors under two kinds of light before three grounds.
const lightingTitles = ['Any light and ground, close up', 'Any light and ground, in the distance', 'Worst light and ground, close up', 'Worst light and ground, in the distance'];
data.lightings.forEach((key, i) => measures.push({key, title: lightingTitles[i], digits: 2, better: 'low',
  note: `${key}: the ${i < 2 ? 'mean' : 'largest'} of six errors, two kinds of light before three grounds, ${sizes[i % 2 * 2]}. Lower is better.`}));
measures.push({key: 'luminance', title: 'Luminance of leaves', digits: 3, better: 'one', note: 'Mean luminance of foliage, over the source\'s; of two kinds of light the worse.'});
// Errors of other pictures, where they were measured.
const litTitles = ['Under eight suns, close up', 'Under eight suns, in the distance', 'Mean of 16 frames, close up', 'Mean of 16 frames, in the distance'];
const litNotes = [sizes[0], sizes[2], sizes[0], sizes[2]];
data.lit.forEach((key, i) => measures.push({key, title: litTitles[i], digits: 2, better: 'low',
  note: `${key}: ${i < 2 ? 'difference of pictures lit from eight directions' : 'difference of what temporal antialiasing shows'}, ${litNotes[i]}. Lower is better.`}));
const chartKeys = [...rmse, 'hausdorff', 'coverage', 'mean_distance', ...data.lightings.slice(2), 'luminance', ...data.lit];
const measureOf = key => measures.find(measure => measure.key === key);

const about = {
  default: 'Coppice: collapses leaf pairs in the order that changes the shaded picture least.',
  mi: 'The published method: collapses leaf pairs by the mutual information of views and leaves.',
  geometric: 'Merges the most similar leaf pair first: distance, size and direction.',
  stochastic: 'Drops leaves in random order; those that stay grow (Cook et al. 2007).',
  prune: 'Drops the least informative leaf; its nearest neighbour grows (Gasch et al. 2018).',
  meshopt: 'meshoptimizer: edge collapse, at equal triangle count.',
  meshopt_sloppy: 'meshoptimizer: clusters vertices on a grid, at equal triangle count.',
  fsa: 'Foliage Simplification Algorithm: collapses the nearest and flattest pair (Remolar et al. 2002).',
  plu: 'Progressive leaves union: rectangles that keep the area of two leaves (Zhang and Blaise 2003).',
  huo: 'Hierarchical union of organs: the same, group by group of stalks (Zhang, Blaise and Jaeger 2006).',
  lines: 'Needles as lines that are merged or sampled, at equal vertex count (Deng et al. 2007).',
  voxels: 'A cloud of voxels with mean opacity and normals, at equal bytes.',
};

// Markers, in a square from -1 to 1; each method has a shape and a dash of its own, so that colour is never alone.
const shapes = {
  default: 'M-1 0A1 1 0 1 0 1 0A1 1 0 1 0 -1 0Z',
  mi: 'M-.9 -.9H.9V.9H-.9Z',
  geometric: 'M0 -1.1L1.1 .9H-1.1Z',
  stochastic: 'M0 -1.25L1.25 0L0 1.25L-1.25 0Z',
  prune: 'M0 1.1L1.1 -.9H-1.1Z',
  meshopt: 'M-.4 -1.2H.4V-.4H1.2V.4H.4V1.2H-.4V.4H-1.2V-.4H-.4Z',
  meshopt_sloppy: 'M-1.1 -.55L-.55 -1.1L0 -.55L.55 -1.1L1.1 -.55L.55 0L1.1 .55L.55 1.1L0 .55L-.55 1.1L-1.1 .55L-.55 0Z',
};
// Levels that other tools wrote take turns with these.
const extraCount = 4;
Object.assign(shapes, {
  fsa: 'M-1.1 -.4H1.1V.4H-1.1Z', plu: 'M-.4 -1.1H.4V1.1H-.4Z', huo: 'M-1.1 -1L1.1 0L-1.1 1Z', lines: 'M1.1 -1L-1.1 0L1.1 1Z', voxels: 'M-1 -1H1V-.4H-1ZM-1 .4H1V1H-1Z',
  extra0: 'M0 -1.2L.8 0L0 1.2L-.8 0Z', extra1: 'M-.7 -1L.7 -1L1.2 0L.7 1L-.7 1L-1.2 0Z', extra2: 'M-1 -1L1 -1L0 0L1 1L-1 1L0 0Z', extra3: 'M-1 -1H-.4V1H-1ZM.4 -1H1V1H.4Z',
});
const dashes = {default: [], mi: [9, 4], geometric: [3, 3], stochastic: [12, 4, 3, 4], prune: [6, 3], meshopt: [2, 4], meshopt_sloppy: [9, 3, 2, 3, 2, 3],
  fsa: [5, 2], plu: [14, 3], huo: [4, 4, 1, 4], lines: [1, 3], voxels: [8, 2, 2, 2], extra0: [10, 2], extra1: [2, 2], extra2: [6, 2, 1, 2], extra3: [16, 4]};

// The names of levels that other tools wrote are anybody's: they are never looked up.
let extras = 0;
const keyOf = name => Object.hasOwn(about, name) ? name : `extra${extras++ % extraCount}`;
const methods = data.methods.map(method => ({...method, key: keyOf(method.name)}))
  .map(method => ({...method, shape: shapes[method.key], dash: dashes[method.key], visible: true}));
const aboutMethod = method => about[method.key] ?? 'Levels that another tool wrote.';
const levels = data.methods[0].levels.map((level, index) => ({index, fraction: level.fraction, leaves: level.leaves}))
  .sort((a, b) => b.leaves - a.leaves);

const percent = fraction => `${+(100 * fraction).toPrecision(3)}%`;
const count = number => number.toLocaleString('en');
const figure = (value, measure) => value === null ? '–' : value.toFixed(measure.digits);
const color = method => getComputedStyle(document.documentElement).getPropertyValue(`--${method.key}`);

// Distance from perfect, for comparisons; what cannot be measured loses.
function badness(value, measure) {
  if (value === null) return Infinity;
  return measure.better === 'low' ? value : measure.better === 'one' ? Math.abs(value - 1) : -value;
}

// Indices of the methods that are best as printed; ties are all best.
function best(level, measure) {
  const scores = methods.map(method => +badness(method.levels[level.index][measure.key], measure).toFixed(measure.digits));
  const lowest = Math.min(...scores);
  return Number.isFinite(lowest) ? scores.flatMap((score, index) => score === lowest ? [index] : []) : [];
}

// element('p', {className: 'x'}, 'text', child...)
function element(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

function symbol(method) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '-1.5 -1.5 3 3');
  svg.setAttribute('aria-hidden', 'true');
  svg.classList.add('symbol');
  const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  path.setAttribute('d', method.shape);
  path.style.fill = `var(--${method.key})`;
  svg.append(path);
  return svg;
}

const label = method => element('span', {className: 'method'}, symbol(method), method.name);

// A row of radio buttons in a fieldset; calls `changed` with the chosen value.
function choice(title, name, options, chosen, changed) {
  const group = element('fieldset', {}, element('legend', {}, title));
  for (const [value, ...text] of options) {
    const input = element('input', {type: 'radio', name, value, checked: value === chosen});
    input.addEventListener('change', () => changed(value));
    group.append(element('label', {}, input, element('span', {}, ...text)));
  }
  return group;
}
