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
  byId('summary').append(`${plural(data.plants.length, 'plant')} in ${time(data.seconds)}: `, `${count(data.baked)} baked, `,
    `${count(data.cached)} cached, `, element('span', {className: data.failed > 0 ? 'bad' : ''}, `${count(data.failed)} failed`), '.');
  const {cache} = data;
  if (!cache.where) byId('cache').remove();
  else byId('cache').textContent = `Cache ${cache.where}: ${count(cache.found)} found, ${count(cache.sent)} sent` +
    (cache.trouble ? `; ${cache.trouble}` : '') + '.';
}

// "baked, 12 s"
const how = plant => `${plant.outcome}, ${time(plant.seconds)}`;

function makeFailures() {
  const failures = data.plants.filter(plant => plant.outcome === 'failed');
  if (failures.length === 0) return;
  byId('failures').hidden = false;
  byId('failed').textContent = `${plural(failures.length, 'plant')} failed`;
  byId('failure_list').append(...failures.map(plant => element('div', {className: 'failure'}, element('strong', {}, plant.name),
    ` (${how(plant)})`, element('div', {className: 'bad'}, plant.error))));
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

makeSummary();
makeFailures();
for (const [id, choices] of [['show', shows], ['sort', sorts]])
  byId(id).append(...Object.entries(choices).map(([value, [text]]) => element('option', {value}, text)));
for (const id of ['find', 'show', 'sort']) byId(id).addEventListener('input', showPlants);
byId('controls').addEventListener('submit', event => event.preventDefault());
new IntersectionObserver(([end]) => { if (end.isIntersecting) showMore(); }, {rootMargin: '1000px'}).observe(byId('end'));
showPlants();
document.documentElement.dataset.report = 'ready';
