// The figures as tables, and who is best where.

const caption = text => element('caption', {}, element('span', {}, text));
const headRow = cells => element('thead', {}, element('tr', {}, ...cells.map(cell => element('th', {scope: 'col'}, ...[cell].flat()))));
const levelHead = level => element('th', {scope: 'row'}, percent(level.fraction), element('small', {}, ` ${count(level.leaves)}`));

function figureTable(measure) {
  const rows = levels.map(level => {
    const winners = best(level, measure);
    return element('tr', {}, levelHead(level), ...methods.map((method, index) => {
      const text = figure(method.levels[level.index][measure.key], measure);
      const title = method.levels[level.index].parameters;
      return winners.includes(index) ? element('td', {className: 'best', title}, `${text} ★`) : element('td', {title}, text);
    }));
  });
  return element('table', {}, caption(`${measure.note} ★ best of the row. Of a method with parameters the best counts: point at a figure for them.`),
    headRow(['level, leaves', ...methods.map(label)]), element('tbody', {}, ...rows));
}

function sizeTable() {
  const rows = methods.map(method => element('tr', {}, element('th', {scope: 'row'}, label(method)),
    element('td', {}, method.seconds.toFixed(method.seconds < 10 ? 2 : 1)),
    ...levels.map(level => element('td', {}, count(method.levels[level.index].triangles)))));
  const heads = levels.map(level => [percent(level.fraction), element('small', {}, ` ${count(level.leaves)}`)]);
  return element('table', {}, caption(`Seconds to simplify to all levels; then triangles at each level (and the leaves asked for). The source has ${count(data.source_triangles)} triangles in ${count(data.source_leaves)} leaves.`),
    headRow(['method', 'seconds', ...heads]), element('tbody', {}, ...rows));
}

function winnersTable() {
  const keys = [...rmse, ...data.lightings, 'luminance', 'hausdorff', 'coverage', ...data.lit];
  const rows = keys.map(key => {
    const measure = measureOf(key);
    return element('tr', {}, element('th', {scope: 'row'}, measure.title, element('small', {}, key)), ...levels.map(level => {
      const winners = best(level, measure);
      return element('td', {}, ...(winners.length > 2 ? [`${winners.length} alike`] : winners.map(index => label(methods[index]))));
    }));
  });
  return element('table', {className: 'winners'}, caption('Best method, by measure and share of leaves kept.'),
    headRow(['measure', ...levels.map(level => percent(level.fraction))]), element('tbody', {}, ...rows));
}

function makeTables() {
  const show = key => document.getElementById('table').replaceChildren(figureTable(measureOf(key)));
  document.getElementById('table_controls').append(
    choice('Measure', 'measure', measures.map(measure => [measure.key, measure.title]), rmse[0], show));
  show(rmse[0]);
  document.getElementById('size_table').append(sizeTable());
  if (methods.length > 1) document.getElementById('winners').append(winnersTable());
}
