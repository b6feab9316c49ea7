// The keys of the rig: a control for each of them, in a section for each table.
'use strict';

const NAMES = { overlay: 'panel (flat drawing)', camera: "camera (the program's)", viewer: 'viewer', dome: 'dome', screen: 'screen', views: 'views', content: 'content', '': 'file' };
const PARTS = [['right', 'up', 'back'], ['x', 'y', 'width', 'height']];
const open = new Set(), shut = new Set();

// A key by its name. The list of keys is a new one after each change of the rig.
let named = { of: null, names: new Map() };
function keyOf(name) {
  if (named.of !== page.keys) named = { of: page.keys, names: new Map(page.keys.map(key => [key.key, key])) };
  return named.names.get(name);
}
// The value that is shown; `null` if the file has none.
function shownValue(name) {
  const key = keyOf(name);
  return optimistic.has(name) ? optimistic.get(name) : key ? key.toml ?? key.value : null;
}
const inFile = key => shownValue(key.key) !== null;

// Names and keys of the sections. Outputs come first, and in them the keys that are often changed.
function groups() {
  const found = new Map(), names = [...new Set(page.keys.map(key => key.output))];
  const rare = /\.(kind|size|window|eye|method|flip|name|lens|node|display|monitor|fullscreen|publish|shown)$/;
  const rank = key => key.output === undefined ? [1, 0, 0] : [0, names.indexOf(key.output), rare.test(key.key) ? 1 : 0];
  const order = (a, b) => { const [x, y] = [rank(a), rank(b)]; return x[0] - y[0] || x[1] - y[1] || x[2] - y[2]; };
  for (const key of [...page.keys].sort(order)) {
    if (key.key === 'passthrough') continue;
    const group = key.output !== undefined ? `output.${key.output}` : key.key.includes('.') ? key.key.split('.')[0] : '';
    if (!found.has(group)) found.set(group, []);
    found.get(group).push(key);
  }
  return found;
}

let shownKeys = '';
const sections = new Map();
function showKeys() {
  const wanted = page.keys.map(key => `${key.key} ${key.type} ${key.count || ''} ${(key.words || []).join()}`).join('\n') + page.state.rig.name;
  if (wanted === shownKeys) { page.keys.forEach(fillKey); showSections(); return; }
  shownKeys = wanted;
  rows.clear();
  sections.clear();
  const first = page.state.rig.outputs[0];
  if (!open.size && first) { open.add(`output.${first}`); open.add('viewer'); open.add('camera'); }
  if (dome && !page.state.rig.outputs.includes(dome.selected)) dome.selected = page.state.rig.outputs.length > 1 ? first : null;
  $('keys').replaceChildren(...[...groups()].map(([group, keys]) => {
    const output = keys[0].output, section = sectionOf(group, output ?? NAMES[group] ?? group, keys, open.has(group));
    if (output !== undefined) section.addEventListener('toggle', () => { if (section.open && !searched()) select(output); });
    return section;
  }));
  showSections();
  filter();
  mark();
}

// A section whose rows are made when it is opened, with a section for each table of an output.
function sectionOf(group, name, keys, isOpen, isInner = false) {
  const section = element('details', { open: isOpen }, element('summary', {}, name, element('small')));
  const fill = () => {
    if (!section.open || section.childElementCount > 1) return;
    const inner = new Map();
    for (const key of keys) {
      const [table, rest] = key.key.slice(group ? group.length + 1 : 0).split(/\.(.*)/s);
      if (!rest || isInner || key.output === undefined) section.append(rowOf(key, group));
      else inner.set(table, [...inner.get(table) || [], key]);
    }
    for (const [table, of] of inner) {
      const path = `${group}.${table}`, usually = table === 'blend' || of.some(inFile);
      section.append(sectionOf(path, table, of, open.has(path) || usually && !shut.has(path), true));
    }
    showSections();
    if (searched() && !isFiltering) filter();
  };
  section.dataset.group = group;
  section.addEventListener('toggle', () => {
    // What a search opens is closed after it.
    if (!searched()) { (section.open ? open : shut).add(group); (section.open ? shut : open).delete(group); }
    fill();
  });
  sections.set(group, { section, keys, fill, isInner });
  fill();
  return section;
}

// Tells which tables the file lacks, and the kinds of the others.
function showSections() {
  for (const [group, { section, keys }] of sections) {
    const kind = keys.find(key => key.key === `${group}.kind` || key.key === `${group}.shape`);
    const isLacking = group && !keys.some(inFile);
    section.classList.toggle('lacking', Boolean(isLacking));
    section.querySelector('small').textContent = isLacking ? 'not in the file' : kind && kind.words ? shownValue(kind.key) ?? '' : '';
  }
}

const rows = new Map();
function rowOf(key, group) {
  const name = group ? key.key.slice(group.length + 1) : key.key;
  const drop = element('button', { className: 'drop', textContent: '×', title: `Remove ${key.key} from the rig${key.default === null ? '' : `: then it is ${key.default}`}` });
  const head = element('div', { className: 'name', title: key.what || '' }, element('span', { textContent: name }), element('small', { textContent: key.what || '' }));
  const row = element('div', { className: 'key' }, head), wrong = element('div', { className: 'wrong' });
  const inputs = [];
  row.dataset.key = key.key;
  drop.onclick = () => unset(key.key);
  if (key.type === 'number' || key.type === 'whole') {
    const count = key.type === 'whole' ? key.ranges.length : key.count || 1;
    for (let i = 0; i < count; i++) inputs.push(numberInput(key, i, count, row));
    row.append(...inputs.map(input => input.row));
  } else if (key.type === 'text' || key.type === 'value') {
    const input = textInput(key);
    inputs.push(input);
    row.append(input.field);
  } else {
    const words = key.type === 'truth' ? ['true', 'false'] : key.words;
    const choice = element('select', {}, element('option', { value: '', textContent: key.default === null ? 'not set' : `not set (${key.default})` }), ...words.map(word => element('option', { value: word, textContent: word })));
    choice.setAttribute('aria-label', key.key);
    choice.onchange = () => { if (choice.value) change(key.key, key.type === 'truth' ? choice.value : JSON.stringify(choice.value), row); else unset(key.key); };
    head.append(choice);
    inputs.push({ show: value => { choice.value = value === null ? '' : String(value); } });
  }
  head.append(drop);
  row.append(wrong);
  rows.set(key.key, { row, inputs, wrong, drop });
  fillKey(key);
  return row;
}

// A field for text, or for a list or a table as the rig file has it.
function textInput(key) {
  const isText = key.type === 'text', field = element(isText ? 'input' : 'textarea', { spellcheck: false, placeholder: key.default ?? 'not set' });
  if (isText) field.type = 'text'; else field.rows = 1;
  field.className = 'written';
  field.setAttribute('aria-label', key.key);
  let shown = '';
  field.onchange = () => {
    const text = isText ? field.value : field.value.trim();
    if (text === shown) accepted(key.key);
    else if (text === '') unset(key.key);
    else change(key.key, isText ? JSON.stringify(text) : text, null);
  };
  field.onkeydown = event => { if (event.key === 'Enter' && !event.shiftKey) { event.preventDefault(); field.onchange(); } };
  return {
    field,
    show: value => {
      // A refused text stays, so that it can be corrected.
      const isWritten = field.value !== shown && (document.activeElement === field || field.parentElement?.classList.contains('bad'));
      shown = value ?? '';
      if (!isWritten) field.value = shown;
    },
  };
}

// The range of a slider: the usual range, around the value if the allowed range is wide.
function sliderRange(key, value, index) {
  const [least, greatest] = key.type === 'whole' ? key.ranges[index] : [key.least, key.greatest];
  const radius = page.scene ? page.scene.radius : 5;
  let low = least, high = greatest;
  if (least > 0 && greatest > 1000 * least) [low, high] = [Math.max(least, value / 10), Math.min(greatest, value * 10)];
  else if (greatest - least > 1000) {
    const reach = /metre/.test(key.what) ? 1.5 * radius : Math.max(10, 2 * Math.abs(value));
    [low, high] = /\.size$|\.window$/.test(key.key) ? [least, Math.max(4096, value)] : [Math.max(least, -reach), Math.min(greatest, reach)];
  } else if (greatest - least > 360) [low, high] = [-180, 180];
  if ($('fine').checked) {
    const span = (high - low) / 40;
    [low, high] = [Math.max(least, value - span / 2), Math.min(greatest, value + span / 2)];
  }
  return [Math.min(low, value), Math.max(high, value)];
}

function numberInput(key, index, count, row) {
  const isWhole = key.type === 'whole';
  const slider = element('input', { type: 'range' }), field = element('input', { type: 'number', step: 'any' });
  const less = element('button', { textContent: '−', tabIndex: -1 }), more = element('button', { textContent: '+', tabIndex: -1 });
  const labels = PARTS.find(names => names.length === count) || [];
  slider.setAttribute('aria-label', `${key.key} ${labels[index] || ''}`);
  field.setAttribute('aria-label', slider.getAttribute('aria-label'));
  let held = false;
  const step = () => isWhole ? 1 : nice((slider.max - slider.min) / 1000);
  const send = (value, gesture) => {
    const now = valueOf(key.key), all = Array.isArray(now) ? [...now] : now === null || now === undefined ? Array.from({ length: count }, (_, i) => startOf(key, i)) : [now];
    all[index] = isWhole ? Math.round(value) : tidy(value, step());
    field.value = all[index];
    const single = key.type === 'number' && !key.count;
    change(key.key, single ? String(all[0]) : `[${all.join(', ')}]`, row, gesture);
    optimistic.set(key.key, single ? all[0] : all);
  };
  slider.oninput = () => send(Number(slider.value), `drag ${key.key}`);
  slider.onpointerdown = () => { held = true; };
  slider.onchange = () => { held = false; fillKey(keyOf(key.key)); };
  field.onchange = () => {
    if (field.value !== '') send(Number(field.value));
    // An empty field removes the key; a part of a list cannot be removed.
    else if (count === 1 && !field.validity.badInput) unset(key.key);
    else fillKey(keyOf(key.key));
  };
  less.onclick = () => send(Number(slider.value) - step() * 4, `step ${key.key}`);
  more.onclick = () => send(Number(slider.value) + step() * 4, `step ${key.key}`);
  const made = element('div', { className: 'number', title: labels[index] || '' }, less, slider, more, field);
  return {
    row: made,
    show: value => {
      const one = Array.isArray(value) ? value[index] : value, at = one ?? startOf(key, index);
      if (!held && document.activeElement !== slider) {
        const [low, high] = sliderRange(key, at, index);
        [slider.min, slider.max, slider.step] = [low, high, isWhole ? 1 : nice((high - low) / 4000)];
      }
      if (!held) slider.value = at;
      if (document.activeElement !== field) { field.value = one === null || one === undefined ? '' : tidy(one, 1e-6); field.placeholder = defaultOf(key, index) ?? ''; }
    },
  };
}

const nice = value => Math.pow(10, Math.floor(Math.log10(value || 1)));
const tidy = (value, step) => Number(value.toFixed(Math.min(6, Math.max(0, Math.ceil(-Math.log10(step)) + 1))));
const defaultOf = (key, index) => Array.isArray(key.default) ? key.default[index] : key.default;
const startOf = (key, index) => defaultOf(key, index) ?? Math.min(Math.max(0, key.least ?? 0), key.greatest ?? 0);
const optimistic = new Map();
const valueOf = name => optimistic.has(name) ? optimistic.get(name) : keyOf(name)?.value ?? null;

function fillKey(key) {
  const found = key && rows.get(key.key);
  if (!found) return;
  const value = shownValue(key.key);
  found.row.classList.toggle('unset', value === null);
  found.drop.hidden = value === null;
  for (const input of found.inputs) input.show(value);
}

// Changes are sent one after the other; the last one of each key counts.
const waiting = new Map();
let sending = false;
function change(key, value, row, gesture) {
  waiting.set(key, { value, row, gesture });
  page.edited = performance.now();
  if (!sending) send();
}
function unset(key) {
  const known = keyOf(key);
  if (known && inFile(known)) change(key, null);
  else if (known) { accepted(key); fillKey(known); }
}
// Takes away the reason of a refusal.
function accepted(key) {
  const found = rows.get(key);
  if (found) { found.wrong.textContent = ''; found.row.classList.remove('bad'); }
}
async function send() {
  sending = true;
  while (waiting.size) {
    const [[key, { value, gesture }]] = waiting;
    waiting.delete(key);
    const found = rows.get(key), known = keyOf(key);
    const remove = value === null ? [key] : rivalsOf(known);
    try {
      take(await command({ do: 'set', changes: value === null ? [] : [`${key}=${value}`], remove, gesture: gesture || null }));
      const isGone = one => remove.some(key => one.key === key || one.key.startsWith(`${key}.`));
      for (const gone of page.keys.filter(isGone)) Object.assign(gone, { given: false, value: null, toml: null });
      if (known && value !== null) known.given = true;
      if (known && known.type === 'value') known.toml = value;
      // Values that TOML writes differently from JSON come with the keys.
      else try { if (known) known.value = JSON.parse(value); } catch { /* The value before is shown until then. */ }
      if (known && key === `output.${known.output}.name`) open.add(`output.${known.value ?? ''}`);
      accepted(key);
      if (!waiting.has(key)) {
        optimistic.delete(key);
        for (const one of [key, ...remove]) fillKey(keyOf(one));
      }
      showSections();
    } catch (error) {
      if (!waiting.has(key)) optimistic.delete(key);
      if (found) { found.wrong.textContent = error.message; found.row.classList.add('bad'); }
      if (!found || !found.row.checkVisibility()) say(error.message);
    }
  }
  optimistic.clear();
  sending = false;
}

// An output has one kind of lens: a key of another one takes the place of those that are in the file.
const RIVALS = { fisheye: ['fov', 'shift', 'angles', 'distortion', 'keystone'], fov: ['fisheye', 'angles', 'lens'], angles: ['fisheye', 'fov', 'shift', 'lens'], lens: ['fov', 'shift', 'angles'] };
function rivalsOf(known) {
  if (!known || known.output === undefined) return [];
  const path = name => `output.${known.output}.${name}`, own = known.key.slice(path('').length).split('.')[0];
  const isThere = name => page.keys.some(key => key.given && (key.key === path(name) || key.key.startsWith(`${path(name)}.`)));
  return (RIVALS[own] || []).filter(isThere).map(path);
}

// Several changes are made together: each of them alone may not be possible.
$('several-apply').onclick = async () => {
  const wrong = $('several-wrong'), changes = [], remove = [];
  const lines = $('several-lines').value.split('\n').map(line => line.trim()).filter(line => line && !line.startsWith('#'));
  for (const line of lines) {
    const [key, value] = line.split(/=(.*)/s).map(part => part.trim());
    if (value === '') remove.push(key); else changes.push(line);
  }
  try {
    take(await command({ do: 'set', changes, remove }));
    [wrong.textContent, $('several-lines').value] = ['', ''];
  } catch (error) { wrong.textContent = error.message; }
};

const searched = () => $('find').value.trim().toLowerCase();
let wasSearched = false, isFiltering = false;
function filter() {
  isFiltering = true;
  const word = searched(), matches = key => key.key.toLowerCase().includes(word), isEnd = wasSearched && !word;
  // Sections of tables that are made here are visited, too.
  for (const [group, { section, keys, isInner, fill }] of sections) {
    const found = keys.some(matches), usually = isInner && !shut.has(group) && (group.endsWith('.blend') || keys.some(inFile));
    section.style.display = !word || found ? '' : 'none';
    if (word) section.open = found;
    else if (isEnd) section.open = open.has(group) || usually;
    fill();
  }
  wasSearched = Boolean(word);
  for (const { row } of rows.values()) row.style.display = !word || row.dataset.key.toLowerCase().includes(word) ? '' : 'none';
  isFiltering = false;
}
$('find').oninput = filter;
$('fine').onchange = () => page.keys.forEach(fillKey);

function select(name) {
  if (dome) { dome.selected = name; dome.draw(); }
  mark();
}
function mark() {
  const name = dome && dome.selected;
  for (const section of $('keys').children) section.classList.toggle('on', section.dataset.group === `output.${name}`);
  for (const output of $('outputs').children) output.classList.toggle('on', output.dataset.name === name);
}

