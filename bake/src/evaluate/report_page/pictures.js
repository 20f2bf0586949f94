// Pictures side by side: all methods at one level, or all levels of one method; as they are or as the difference to the source; at the three
// sizes at which errors are measured.

const shown = {compare: 'methods', level: '', method: '0', mode: 'picture', size: '256'};
const sizeMeasure = {256: 'rmse_256', 64: 'rmse_64', 16: 'rmse_16'};

// Halves a picture until it is `size` wide: each pixel is then the mean of those it covers. Resolves to a data URL.
async function shrunk(url, size) {
  const image = new Image();
  image.src = url;
  await image.decode();
  if (size >= image.width) return url;
  let from = image;
  for (let width = image.width / 2; width >= size; width /= 2) {
    const canvas = element('canvas', {width, height: width});
    canvas.getContext('2d').drawImage(from, 0, 0, width, width);
    from = canvas;
  }
  return from.toDataURL();
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

async function drawGallery() {
  const source = await shrunk(data.source_picture, +shown.size);
  const figures = await Promise.all(tiles().map(async ({url, title, note, text}) => {
    const picture = element('div', {className: 'picture', role: 'img', ariaLabel: shown.mode === 'difference' ? `difference of ${text} to the source` : text});
    const images = [await shrunk(url, +shown.size)];
    if (shown.mode === 'difference') images.push(source);
    picture.style.backgroundImage = images.map(image => `url(${image})`).join(', ');
    picture.classList.toggle('difference', shown.mode === 'difference');
    picture.classList.toggle('coarse', shown.size !== '256');
    return element('figure', {}, picture, element('figcaption', {}, element('strong', {}, ...title), element('span', {}, ...note)));
  }));
  document.getElementById('gallery').replaceChildren(...figures);
}

function drawPictureControls() {
  const set = key => value => {
    shown[key] = value;
    if (key === 'compare') drawPictureControls();
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
