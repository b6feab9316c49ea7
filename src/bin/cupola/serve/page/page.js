// The page around the dome: its state, pictures, patterns, outputs, health.
'use strict';

const $ = id => document.getElementById(id);
const token = location.hash.slice(1);
const element = (name, properties = {}, ...inside) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...inside);
  return made;
};

// State for tests, and for people who look at it.
const page = window.cupola = { frames: 0, state: null, keys: [], firstPicture: 0, lastFrame: 0, pictureVersion: null, sceneVersion: -1, edited: -1e9 };
let dome = null;

async function ask(path, options = {}) {
  const answer = await fetch(path, { ...options, headers: { 'X-Cupola-Token': token }, cache: 'no-store' });
  if (!answer.ok) throw new Error(await answer.text());
  return answer;
}

async function command(what) {
  const answer = await ask('/do', { method: 'POST', body: JSON.stringify(what) });
  return answer.json();
}

let silence = 0;
function say(text, good = false) {
  $('message').textContent = text;
  $('message').className = good ? 'good' : '';
  clearTimeout(silence);
  silence = setTimeout(() => { $('message').textContent = ''; }, good ? 2500 : 9000);
}
$('message').onclick = () => { $('message').textContent = ''; };
try { dome = new Dome($('view'), $('labels')); } catch (error) { say(error.message); }
page.dome = dome;

async function act(what) {
  try { take(await command(what)); return true; } catch (error) { say(error.message); return false; }
}

// ---- state ----

function options(select, names, chosen) {
  const wanted = names.join('\n');
  if (select.dataset.names !== wanted) {
    select.replaceChildren(...names.map(name => element('option', { value: name, textContent: short(name) })));
    select.dataset.names = wanted;
  }
  if (chosen !== undefined && document.activeElement !== select) select.value = chosen;
}
const short = name => name.length > 34 ? `…${name.slice(-33)}` : name;

let version = -1, places = -1, later = 0, changed = () => {};
// Waits until the server has taken a change.
const nextChange = () => new Promise(done => { changed = done; });
function take(state) {
  page.state = state;
  const { rig, program } = state;
  options($('rigs'), [...new Set(state.rigs.includes(rig.name) ? state.rigs : [rig.name, ...state.rigs])], rig.name);
  options($('programs'), state.programs);
  $('programs').hidden = $('start').hidden = state.programs.length === 0;
  $('undo').disabled = rig.undo === 0;
  $('redo').disabled = rig.redo === 0;
  $('save').disabled = !rig.changed;
  $('save').classList.toggle('bright', rig.changed);
  $('stop').disabled = !program.runs;
  $('time').hidden = !state.clock;
  $('hold').textContent = state.clock && state.clock.held ? 'Go on' : 'Hold time';
  document.title = `${rig.changed ? '• ' : ''}${rig.title} – Cupola`;
  options($('only'), ['all outputs', ...rig.outputs], state.pattern.only || 'all outputs');
  for (const button of $('parts').children) button.classList.toggle('on', state.pattern.parts.includes(button.dataset.part));
  $('off').classList.toggle('on', state.pattern.parts.length === 0 && state.pattern.at.length === 0 && !state.pattern.cursor);
  showHealth(state);
  showMarks(state);
  if (state.places !== places) { places = state.places; fetchScene(); }
  if (state.version !== version) {
    version = state.version;
    changed();
    // The keys are fetched with a delay while changes follow each other: the page knows its own changes.
    clearTimeout(later);
    later = setTimeout(refresh, page.keys.length ? 600 : 0);
  }
}

function showHealth(state) {
  const milliseconds = state.frame_milliseconds, megabytes = bytes => `${Math.round(bytes / 1048576)} MiB`;
  const { program } = state;
  const words = program.runs
    ? [state.clock?.held ? 'time held' : milliseconds ? `<b>${(1000 / milliseconds).toFixed(1)}</b> frames/s` : 'starts', `<b>${megabytes(state.memory.program)}</b>`]
    : [program.ended ? 'program failed' : 'no program'];
  $('health').innerHTML = words.join(' · ');
  $('note').textContent = $('overlay').value !== 'picture' ? '' : !program.runs ? (program.ended ? 'The program ended; see Health.' : 'No program runs: the lines are angles of the dome.')
    : Object.keys(dome ? dome.rects : page.rects || {}).length === 0 ? 'Waiting for the program’s first picture.' : '';
  if (!$('state').classList.contains('on')) return;
  const s = state.statistics, rows = [['Rig', state.rig.name], ['Program', program.name ? `${program.name}${program.runs ? '' : ' (not running)'}` : 'none']];
  if (program.ended) rows.push(['It ended', program.ended]);
  if (milliseconds && program.runs) rows.push(['From frame to frame', `${milliseconds.toFixed(2)} ms`]);
  if (state.clock && state.clock.frame !== null) rows.push(['Time', `frame ${state.clock.frame}, ${state.clock.seconds.toFixed(4)} s${state.clock.held ? ', held' : ''}`]);
  rows.push(['Memory', `${megabytes(state.memory.program)} program, ${megabytes(state.memory.server)} this page's server`]);
  if (s) {
    rows.push(['Graphics driver', s.driver], ['Frames', s.frames], ['Draws of a frame', `${s.draws_seen}, of which ${s.panel_draws} flat`]);
    rows.push(['Views', s.views.map(v => `${v.name} ${v.width}×${v.height}`).join(', ')]);
    for (const [name, value] of Object.entries(s.milliseconds || {})) {
      if (value && typeof value === 'object') rows.push([`${name.replaceAll('_', ' ')}, ms`, Object.entries(value).filter(([, v]) => typeof v === 'number').map(([n, v]) => `${n} ${v.toFixed(2)}`).join(', ')]);
      else if (typeof value === 'number') rows.push([`${name.replaceAll('_', ' ')}, ms`, value.toFixed(2)]);
    }
    for (const note of s.notes || []) rows.push(['Note', note]);
  }
  const table = element('table', {}, ...rows.map(([name, value]) => element('tr', {}, element('td', { textContent: name }), element('td', { textContent: value }))));
  $('state').replaceChildren(table, element('pre', { textContent: program.lines.join('\n') }));
}

async function poll() {
  for (;;) {
    try {
      if (!document.hidden && !sending) take(await command({ do: 'state' }));
      lost = false;
    } catch (error) {
      if (!lost) say(`The server does not answer: ${error.message}`);
      lost = true;
    }
    await new Promise(done => setTimeout(done, 1000));
  }
}
let lost = false;

// Fetches everything that depends on the rig again, one thing at a time.
let refreshing = false, again = false;
async function refresh() {
  if (refreshing) { again = true; return; }
  refreshing = true;
  do {
    again = false;
    try {
      page.keys = await command({ do: 'keys' });
      showKeys();
      if (page.scene) { showOutputs(); await showOverlay(); }
    } catch (error) { say(error.message); }
  } while (again);
  refreshing = false;
}

// The scene as the server sends it: JSON, points of lines, and the meshes of outputs that the page does not have.
function unpacked(bytes, before) {
  const length = new DataView(bytes).getUint32(0, true), known = new Map(before ? before.outputs.map(output => [output.mesh, output]) : []);
  const answer = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  let at = 4 + length;
  const next = (Kind, count) => { at += 4 * count; return new Kind(bytes, at - 4 * count, count); };
  const { scene } = answer;
  scene.lines = scene.lines.map(count => next(Float32Array, 3 * count));
  for (const output of scene.outputs) {
    const [vertices, triangles, coarse] = output.counts, same = known.get(output.mesh);
    if (same) for (const part of ['points', 'uv', 'triangles', 'coarse', 'edge']) output[part] = same[part];
    else Object.assign(output, { points: next(Float32Array, 3 * vertices), uv: next(Float32Array, 2 * vertices), triangles: next(Uint32Array, 3 * triangles), coarse: next(Uint32Array, 3 * coarse) });
  }
  return answer;
}

// A changed picture belongs on the changed dome: scene and picture of a version wait for each other, but not for long.
const arrived = { scene: -1, picture: -1 }, meeting = new Set();
function arrives(kind, at) {
  arrived[kind] = at ?? arrived[kind];
  for (const look of meeting) look();
}
function meets(kind, at) {
  return new Promise(done => {
    const look = () => { if (arrived[kind] >= at) end(); }, end = () => { meeting.delete(look); clearTimeout(limit); done(); };
    const limit = setTimeout(end, 250);
    meeting.add(look);
    look();
  });
}

// Fetches the positions of the light as soon as they change, one request after the other.
let fetching = false, fetchAgain = false;
async function fetchScene() {
  if (fetching) { fetchAgain = true; return; }
  fetching = true;
  do {
    fetchAgain = false;
    try {
      const have = page.scene ? page.scene.outputs.map(output => output.mesh).join() : '';
      const { scene, version: sceneVersion } = unpacked(await (await ask(`/scene?have=${have}`)).arrayBuffer(), page.scene);
      const isFirst = !page.scene;
      arrives('scene', sceneVersion);
      if (page.pictureVersion !== null && performance.now() - page.lastFrame < 1000) await meets('picture', sceneVersion);
      Object.assign(page, { scene, sceneVersion });
      if (dome) dome.setScene(scene);
      showOutputs();
      if (isFirst) page.keys.forEach(fillKey);
      if (isFirst || $('overlay').value !== 'picture') await showOverlay();
    } catch (error) { say(error.message); }
  } while (fetchAgain);
  fetching = false;
}

async function showOverlay() {
  if (!dome) return;
  const kind = dome.overlay = $('overlay').value;
  if (page.state) showHealth(page.state);
  if (kind === 'picture' || kind === 'error') { dome.values = null; dome.draw(); }
  else {
    const { values } = await (await ask(`/overlay?kind=${kind}`)).json();
    if (values.length === dome.outputs.length && $('overlay').value === kind) dome.setValues(values);
  }
  showLegend(kind);
}

function showLegend(kind) {
  const legend = $('legend'), [least, greatest] = dome.range();
  legend.style.display = kind === 'picture' ? 'none' : 'block';
  if (kind === 'coverage') {
    const colors = ['#808080', '#44aa5a', '#5069cc', '#cc5050'];
    legend.replaceChildren('lit by', ...colors.flatMap((color, i) => {
      const box = element('i');
      box.style.background = color;
      return [box, i === 3 ? '4 or more' : `${i + 1}`];
    }));
  } else if (kind !== 'picture') {
    const bar = element('canvas', { width: 200, height: 1 }), context = bar.getContext('2d');
    for (let i = 0; i < 200; i++) {
      const part = j => Math.round(255 * Math.pow(0.8 * Math.min(Math.max(1.5 - Math.abs(4 * i / 199 - j), 0), 1), 1 / 2.2));
      context.fillStyle = `rgb(${part(3)},${part(2)},${part(1)})`;
      context.fillRect(i, 0, 1, 1);
    }
    const unit = { light: 'of full white', density: 'texels per pixel', resolution: 'pixels per degree', error: '° off' }[kind];
    const digits = greatest < 5 ? 2 : 0;
    legend.replaceChildren(unit, bar, element('div', {}, element('span', { textContent: least.toFixed(digits) }), element('span', { textContent: greatest.toFixed(digits) })));
  }
}

// ---- patterns ----

const PATTERNS = { horizon: 'Azimuth and elevation', dome: 'Angles of the dome', border: 'Borders and names', overlap: 'Overlaps', seams: 'Seams', ramps: 'Grey and colour', focus: 'Focus', white: 'White' };
for (const [part, name] of Object.entries(PATTERNS)) {
  const button = element('button', { textContent: name });
  button.dataset.part = part;
  button.onclick = () => {
    const shown = page.state.pattern.parts, order = ['white', 'ramps', 'focus', 'overlap', 'seams', 'horizon', 'dome', 'border'];
    showPattern({ parts: order.filter(other => shown.includes(other) !== (other === part)) });
  };
  $('parts').append(button);
}
async function showPattern(what) {
  const { parts, at } = page.state.pattern, only = $('only').value;
  const choice = { parts, at, ...what, step: Number($('step').value) || 10, only: only === 'all outputs' ? null : only };
  await act({ do: 'pattern', ...choice });
}
$('only').onchange = $('step').onchange = () => showPattern({});
$('off').onclick = () => act({ do: 'pattern', parts: [] });
$('cross').onclick = () => showPattern({ at: [[Number($('azimuth').value), Number($('elevation').value)]] });

// ---- outputs ----

function showOutputs() {
  const list = $('outputs'), outputs = page.scene.outputs;
  const wanted = outputs.map(output => `${output.name} ${output.size}`).join();
  if (list.dataset.shown === wanted) return;
  list.dataset.shown = wanted;
  list.replaceChildren(...outputs.map(output => {
    const box = element('div', { className: 'output' }, element('span', {}, output.name, element('small', { textContent: `${output.kind} ${output.size.join(' × ')}` })), element('canvas', { width: 480, height: Math.round(480 * output.size[1] / output.size[0]) }));
    box.dataset.name = output.name;
    box.onclick = () => select(output.name);
    return box;
  }));
  mark();
  drawOutputs();
}
function drawOutputs() {
  if (!page.bitmap || !$('outputs').classList.contains('on')) return;
  for (const box of $('outputs').children) {
    const rect = page.rects[box.dataset.name], canvas = box.querySelector('canvas');
    if (rect) canvas.getContext('2d').drawImage(page.bitmap, ...rect, 0, 0, canvas.width, canvas.height);
  }
}

// ---- pictures ----

async function pictures() {
  let after = 0;
  for (;;) {
    try {
      if (document.hidden) { await new Promise(done => setTimeout(done, 300)); continue; }
      // While the rig is edited, smaller pictures come sooner.
      const isEdited = performance.now() - page.edited < 1500;
      const side = $('outputs').classList.contains('on') ? 1024 : page.scene && page.scene.outputs.length > 2 && !isEdited ? 768 : isEdited ? 384 : 512;
      const answer = await ask(`/frame?after=${after}&side=${page.side || side}`);
      if (answer.status === 204) {
        if (!page.state || !page.state.program.runs) { page.rects = {}; if (dome && Object.keys(dome.rects).length) { dome.rects = {}; dome.draw(); } }
        continue;
      }
      after = Number(answer.headers.get('X-Cupola-Frame'));
      const rects = Object.fromEntries(answer.headers.get('X-Cupola-Places').split(';').map(place => {
        const cut = place.lastIndexOf(':');
        return [place.slice(0, cut), place.slice(cut + 1).split(',').map(Number)];
      }));
      const shown = answer.headers.get('X-Cupola-Version'), pictureVersion = shown ? Number(shown) : null;
      // For a moment after a change, a picture that shows nothing new would only delay the one that does.
      const awaits = sending || page.state && page.state.version > pictureVersion;
      if (awaits && pictureVersion !== null && pictureVersion === page.pictureVersion && performance.now() - page.edited < 200) continue;
      const bitmap = await createImageBitmap(await answer.blob());
      arrives('picture', pictureVersion);
      if (pictureVersion !== null && page.scene) await meets('scene', Math.min(pictureVersion, page.state.places));
      if (page.bitmap) page.bitmap.close();
      Object.assign(page, { bitmap, rects, frames: page.frames + 1, lastFrame: performance.now(), pictureVersion });
      page.firstPicture ||= performance.now();
      if (dome) dome.setFrame(bitmap, rects);
      drawOutputs();
      // The next picture is requested when this one is painted: a slow browser gets fewer pictures, but new ones.
      // After a change it does not wait.
      if (dome) await Promise.race([dome.isPainted(), nextChange()]);
    } catch (error) { await new Promise(done => setTimeout(done, 500)); }
  }
}

// ---- buttons and keys ----

$('undo').onclick = () => act({ do: 'undo' });
$('redo').onclick = () => act({ do: 'redo' });
$('save').onclick = async () => {
  try { take(await command({ do: 'save' })); say(`${page.state.rig.name} is saved.`, true); } catch (error) {
    if (/somebody else/.test(error.message) && confirm(`${error.message}\n\nReplace it?`)) act({ do: 'save', replace: true }); else say(error.message);
  }
};
$('rigs').onchange = async () => {
  const name = $('rigs').value;
  const replace = page.state.rig.changed && confirm('The changes of this rig are not saved. Open the other one without them?');
  if (page.state.rig.changed && !replace) { $('rigs').value = page.state.rig.name; return; }
  open.clear();
  if (!await act({ do: 'rig', name, replace: Boolean(replace) })) $('rigs').value = page.state.rig.name;
};
$('start').onclick = () => act({ do: 'start', program: $('programs').value });
$('stop').onclick = () => act({ do: 'stop' });
$('hold').onclick = () => act({ do: page.state.clock && page.state.clock.held ? 'resume' : 'pause' });
$('one').onclick = () => act({ do: 'step' });
document.addEventListener('keydown', event => {
  if (!(event.ctrlKey || event.metaKey)) return;
  const what = { z: event.shiftKey ? 'redo' : 'undo', y: 'redo', s: 'save' }[event.key.toLowerCase()];
  if (what && !/number|search|text/.test(event.target.type)) { event.preventDefault(); $(what).click(); }
});
