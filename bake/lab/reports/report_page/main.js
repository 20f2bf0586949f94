// Puts the page together. When all is drawn the root element gets data-report="ready".

const themes = ['automatic', 'light', 'dark'];
const systemIsDark = matchMedia('(prefers-color-scheme: dark)');

function setTheme(theme) {
  document.documentElement.dataset.theme = theme !== 'automatic' ? theme : systemIsDark.matches ? 'dark' : 'light';
  document.querySelector('#theme span').textContent = theme;
  for (const chart of charts) chart.redraw(false);
}

function makeText() {
  document.title = `${data.plant}: Coppice evaluation`;
  document.getElementById('plant').textContent = data.plant;
  document.getElementById('source').textContent =
    `${count(data.source_leaves)} leaves, ${methods.length} ${methods.length === 1 ? 'method' : 'methods'}, ${levels.length} ${levels.length === 1 ? 'level' : 'levels'} of detail, compared with its leaf ${data.reference}${data.setup === 'paper' ? ', in the set-up of the paper' : ''}`;
  const meshes = data.reference === 'meshes';
  document.getElementById('reference').textContent = meshes ? 'the source plant\'s leaves as they were modelled, with their textures' :
    'the source plant\'s leaf quads, all of them';
  if (data.setup === 'paper') document.getElementById('setup').textContent = ' Leaves are plain rectangles, each material opaque in its mean colour.';
  document.getElementById('distance').textContent = data.view_distance;
  if (data.lit.length === 0) document.getElementById('lit').remove();
  document.getElementById('colours').textContent = meshes ? 'with textures' : 'each material in its mean colour';
  document.getElementById('headline').append(...data.headline.map(sentence => {
    const subject = sentence.search(/[,:]/);
    return element('li', {}, element('strong', {}, sentence.slice(0, subject)), sentence.slice(subject));
  }));
  document.getElementById('warnings').append(...data.warnings.map(warning => element('li', {}, `Importing: ${warning}`)));
  document.getElementById('methods').append(...methods.flatMap(method => [element('dt', {}, label(method)), element('dd', {}, aboutMethod(method))]));
}

async function makePage() {
  let theme = 0;
  setTheme('automatic');
  makeText();
  makeCharts();
  makeTables();
  await makePictures();
  document.getElementById('theme').addEventListener('click', () => setTheme(themes[theme = (theme + 1) % themes.length]));
  systemIsDark.addEventListener('change', () => setTheme(themes[theme]));
  document.documentElement.dataset.report = 'ready';
}

makePage();
