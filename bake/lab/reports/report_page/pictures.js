// Pictures side by side: all methods at one level, or all levels of one method; as they are or as the difference to the source; at the three
// sizes at which errors are measured.

const shown = {compare: 'methods', level: '', method: '0', mode: 'picture', size: '256'};
const sizeMeasure = {256: rmse[0], 64: rmse[1], 16: rmse[2]};

function canvasOf(size) {
  const canvas = element('canvas', {width: size, height: size});
  return {canvas, context: canvas.getContext('2d')};
}

// Halves a picture until it is `size` wide: each pixel is then the mean of those it covers. Resolves to what can be drawn.
async function shrunk(url, size) {
  let from = new Image();
  from.src = url;
  await from.decode();
  while (from.width > size) {
    const {canvas, context} = canvasOf(from.width / 2);
    context.drawImage(from, 0, 0, canvas.width, canvas.height);
    from = canvas;
  }
  return from;
}

// White where two pictures of one size agree, the darker the more they differ.
function difference(one, other) {
  const {canvas, context} = canvasOf(one.width);
  context.drawImage(one, 0, 0);
  context.globalCompositeOperation = 'difference';
  context.drawImage(other, 0, 0);
  context.fillStyle = '#fff';
  context.fillRect(0, 0, canvas.width, canvas.height);
  return canvas;
}

function bestMark(level, measure, methodIndex) {
  return best(level, measure).includes(methodIndex) ? element('span', {className: 'best', title: 'best of this level'}, ' ★') : '';
}

// {url, title nodes, note nodes, text}
function tiles() {
  const measure = measureOf(sizeMeasure[shown.size]);
  const source = {url: data.source_picture, title: ['source'], note: [`${count(data.source_leaves)} leaves`], text: 'source'};
  const tile = (methodIndex, level, title, text) => {
    const figures = methods[methodIndex].levels[level.index];
    return {url: figures.picture, title, text,
      note: [`${measure.key} ${figure(figures[measure.key], measure)}`, bestMark(level, measure, methodIndex)]};
  };
  if (shown.compare === 'methods') {
    const level = levels[+shown.level];
    return [source, ...methods.map((method, index) => tile(index, level, [label(method)], `${method.name} at ${percent(level.fraction)}`))];
  }
  const method = methods[+shown.method];
  return [source, ...levels.map(level => tile(+shown.method, level, [`${percent(level.fraction)}: ${count(level.leaves)} leaves`], `${method.name} at ${percent(level.fraction)}`))];
}

let galleryRequests = 0;

async function drawGallery() {
  const request = ++galleryRequests;
  const source = await shrunk(data.source_picture, +shown.size);
  const figures = await Promise.all(tiles().map(async ({url, title, note, text}) => {
    const differs = shown.mode === 'difference' && url !== data.source_picture;
    const seen = await shrunk(url, +shown.size);
    const drawn = differs ? difference(seen, source) : seen;
    const picture = element('img', {className: 'picture', src: drawn.src ?? drawn.toDataURL(), alt: differs ? `difference of ${text} to the source` : text});
    picture.classList.toggle('difference', differs);
    picture.classList.toggle('coarse', shown.size !== '256');
    return element('figure', {}, picture, element('figcaption', {}, element('strong', {}, ...title), element('span', {}, ...note)));
  }));
  if (request === galleryRequests) document.getElementById('gallery').replaceChildren(...figures);
}

function drawPictureControls() {
  const set = key => value => {
    shown[key] = value;
    if (key === 'compare') {
      drawPictureControls();
      document.querySelector('input[name=compare]:checked').focus();
    }
    drawGallery();
  };
  const which = shown.compare === 'methods' ?
    choice('at', 'level', levels.map((level, index) => [String(index), percent(level.fraction)]), shown.level, set('level')) :
    choice('of', 'method', methods.map((method, index) => [String(index), label(method)]), shown.method, set('method'));
  document.getElementById('picture_controls').replaceChildren(
    choice('Compare', 'compare', [['methods', 'methods'], ['levels', 'levels']], shown.compare, set('compare')),
    which,
    choice('Show', 'mode', [['picture', 'picture'], ['difference', 'difference to source']], shown.mode, set('mode')),
    choice('Size', 'size', [['256', '256 px'], ['64', '64 px'], ['16', '16 px']], shown.size, set('size')));
}

async function makePictures() {
  if (data.source_picture === null) {
    document.getElementById('picture_section').remove();
    return;
  }
  // The level at which methods differ to the eye: a tenth of the leaves, or what comes nearest.
  const nearest = levels.map(level => Math.abs(Math.log(level.fraction / 0.1)));
  shown.level = String(nearest.indexOf(Math.min(...nearest)));
  drawPictureControls();
  await drawGallery();
}
