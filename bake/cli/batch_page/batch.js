'use strict';
// What became of the plants of a batch. When all is drawn the root element gets data-report="ready".

const data = JSON.parse(document.getElementById('data').textContent);
const byId = id => document.getElementById(id);
const count = number => number.toLocaleString('en');
const plural = (number, one, many = `${one}s`) => `${count(number)} ${number === 1 ? one : many}`;
const bytes = number => number >= 1e6 ? `${(number / 1e6).toFixed(1)} MB` : `${(number / 1e3).toFixed(0)} kB`;

function time(seconds) {
  if (seconds < 100) return `${seconds.toFixed(seconds < 10 ? 1 : 0)} s`;
  const minutes = Math.round(seconds / 60);
  return minutes < 120 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

// element('p', {className: 'x'}, 'text', child...)
function element(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

function makeSummary() {
  document.title = `${data.folder}: Coppice bake`;
  byId('folder').textContent = data.folder;
  const where = data.tasks > 0 ? ` on ${plural(data.nodes, 'node')} in ${plural(data.tasks, 'task')}` : '';
  byId('summary').append(`${plural(data.plants.length, 'plant')} in ${time(data.seconds)}${where}: `, `${count(data.baked)} baked, `,
    `${count(data.cached)} cached, `, element('span', {className: data.failed > 0 ? 'bad' : ''}, `${count(data.failed)} failed`), '.');
  const {cache} = data;
  if (!cache.where) byId('cache').remove();
  else byId('cache').textContent = `Cache ${cache.where}: ${count(cache.found)} found, ${count(cache.sent)} sent` +
    (cache.damaged > 0 ? `, ${count(cache.damaged)} damaged` : '') + (cache.trouble ? `; ${cache.trouble}` : '') + '.';
}

// "baked on node2, 12 s, waited 3.0 s, 2 attempts"
function how(plant) {
  const parts = [`${plant.outcome}${plant.node ? ` on ${plant.node}` : ''}`, time(plant.seconds)];
  if (plant.queue_seconds > 0) parts.push(`waited ${time(plant.queue_seconds)}`);
  if (plant.attempts > 1) parts.push(`${plant.attempts} attempts`);
  return parts.join(', ');
}

function makeFailures() {
  const failures = data.plants.filter(plant => plant.outcome === 'failed');
  if (failures.length === 0) return;
  byId('failures').hidden = false;
  byId('failed').textContent = `${plural(failures.length, 'plant')} failed`;
  byId('failure_list').append(...failures.map(plant => {
    const log = plant.log ? [element('details', {}, element('summary', {}, 'The end of its task\'s log'), element('pre', {}, plant.log))] : [];
    return element('div', {className: 'failure'}, element('strong', {}, plant.name), ` (${how(plant)})`, element('div', {className: 'bad'}, plant.error), ...log);
  }));
}

function enlarge(plant) {
  const dialog = byId('large');
  dialog.querySelector('img').src = plant.picture;
  dialog.querySelector('p').textContent = plant.name;
  dialog.showModal();
}
byId('large').addEventListener('click', () => byId('large').close());

function card(plant) {
  const picture = plant.picture ? element('img', {src: plant.picture, alt: `${plant.name}, near and far`}) : element('div', {className: 'none'}, 'no picture');
  if (plant.picture) picture.addEventListener('click', () => enlarge(plant));
  const line = plant.outcome === 'failed' ? element('div', {className: 'bad'}, plant.error) :
    element('div', {}, `${plural(plant.source_leaves, 'leaf', 'leaves')}, ${bytes(plant.file_bytes)}`);
  const warnings = plant.warnings.map(warning => element('div', {className: 'warn'}, `⚠ ${warning}`));
  const because = plant.because.map(line => element('div', {className: 'because'}, line));
  return element('figure', {className: 'plant'}, picture,
    element('figcaption', {}, element('strong', {}, plant.name), line, element('small', {}, how(plant)), ...warnings, ...because));
}

const shows = {all: ['all', () => true], baked: ['baked', plant => plant.outcome === 'baked'], cached: ['cached', plant => plant.outcome === 'cached'],
  failed: ['failed', plant => plant.outcome === 'failed'], warned: ['with warnings', plant => plant.warnings.length > 0]};
const sorts = {name: ['name', (a, b) => a.name < b.name ? -1 : a.name > b.name ? 1 : 0], seconds: ['time', (a, b) => b.seconds - a.seconds],
  leaves: ['leaves', (a, b) => (b.source_leaves ?? 0) - (a.source_leaves ?? 0)], size: ['file size', (a, b) => (b.file_bytes ?? 0) - (a.file_bytes ?? 0)],
  per_leaf: ['bytes per leaf', (a, b) => (b.bytes_per_leaf ?? 0) - (a.bytes_per_leaf ?? 0)]};

// Cards come as the reader nears the end of those that are there: there may be ten thousand.
let waiting = [];
function showMore() {
  byId('gallery').append(...waiting.splice(0, 120).map(card));
}
function showPlants() {
  const find = byId('find').value.toLowerCase();
  waiting = data.plants.filter(plant => shows[byId('show').value][1](plant) && plant.name.toLowerCase().includes(find)).sort(sorts[byId('sort').value][1]);
  byId('shown').textContent = plural(waiting.length, 'plant');
  byId('gallery').replaceChildren();
  showMore();
}

function svg(tag, attributes, ...children) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// Tries of tasks that overlap on one node lie below each other.
function lanesOf(tries) {
  const ends = [];
  return tries.map(made => {
    let lane = ends.findIndex(end => end <= made.start_seconds);
    if (lane < 0) lane = ends.length;
    ends[lane] = made.start_seconds + made.seconds;
    return lane;
  });
}

function makeTimeline(names) {
  const end = Math.max(1, data.seconds, ...data.tries.map(made => made.start_seconds + made.seconds));
  const left = 120, width = 1000, row = 12, parts = [];
  let y = 8;
  for (const name of names) {
    const tries = data.tries.filter(made => made.node === name), lanes = lanesOf(tries);
    parts.push(svg('text', {x: 8, y: y + 11}, name));
    tries.forEach((made, i) => {
      const lost = made.exit === null || made.exit > 1;  // 1: a plant failed
      const bar = svg('rect', {x: left + (width - left - 16) * made.start_seconds / end, y: y + lanes[i] * (row + 2), height: row,
        width: Math.max(3, (width - left - 16) * made.seconds / end - 1), class: lost ? 'lost' : 'done'},
        svg('title', {}, `task ${made.task}, from ${time(made.start_seconds)} on${made.exit === null ? ': lost' : `, ${time(made.seconds)}, exit code ${made.exit}`}`));
      parts.push(bar);
    });
    y += (1 + Math.max(0, ...lanes)) * (row + 2) + 8;
  }
  for (const share of [0, 0.25, 0.5, 0.75, 1])
    parts.push(svg('text', {x: left + (width - left - 16) * share, y: y + 12, class: 'axis', 'text-anchor': share === 1 ? 'end' : 'start'}, time(share * end)));
  byId('timeline').append(svg('svg', {viewBox: `0 0 ${width} ${y + 20}`, role: 'img', 'aria-label': 'Tasks on nodes by time'}, ...parts));
}

function makeNodes() {
  if (!data.tries || data.tries.length === 0) return;
  byId('nodes').hidden = false;
  const names = [...new Set(data.tries.map(made => made.node))].sort();
  makeTimeline(names);
  const rows = names.map(name => {
    const plants = data.plants.filter(plant => plant.node === name), tries = data.tries.filter(made => made.node === name);
    const sum = (list, key) => list.reduce((total, entry) => total + entry[key], 0);
    const waits = plants.map(plant => plant.queue_seconds);
    return [name, count(tries.length), count(tries.filter(made => made.exit === null).length), count(plants.length),
      count(plants.filter(plant => plant.outcome === 'cached').length), time(sum(tries, 'seconds')), time(sum(plants, 'seconds')), time(Math.max(0, ...waits))];
  });
  const head = ['node', 'tasks', 'lost', 'plants', 'cached', 'in tasks', 'in bakes', 'longest wait'];
  byId('node_table').append(element('table', {}, element('thead', {}, element('tr', {}, ...head.map(text => element('th', {scope: 'col'}, text)))),
    element('tbody', {}, ...rows.map(row => element('tr', {}, ...row.map((text, i) => element(i === 0 ? 'th' : 'td', {}, text)))))));
}

makeSummary();
makeFailures();
for (const [id, choices] of [['show', shows], ['sort', sorts]])
  byId(id).append(...Object.entries(choices).map(([value, [text]]) => element('option', {value}, text)));
for (const id of ['find', 'show', 'sort']) byId(id).addEventListener('input', showPlants);
byId('controls').addEventListener('submit', event => event.preventDefault());
new IntersectionObserver(([end]) => { if (end.isIntersecting) showMore(); }, {rootMargin: '1000px'}).observe(byId('end'));
showPlants();
makeNodes();
document.documentElement.dataset.report = 'ready';
