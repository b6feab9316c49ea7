// Marks for the calibration: a crosshair on one output, moved by keys and by the pointer.

const cursor = { x: 0, y: 0, wanted: false, sending: false };
const markOutput = () => page.scene && page.scene.outputs.find(output => output.name === $('mark-output').value);

function showMarks(state) {
  options($('mark-output'), state.rig.outputs);
  const { file, list } = state.marks;
  $('mark-file').textContent = file ? `Marks are kept in ${file}.` : 'Marks are lost with the server; start it with --marks FILE.csv to keep them.';
  const wanted = JSON.stringify(list);
  if ($('marks-list').dataset.shown !== wanted) {
    $('marks-list').dataset.shown = wanted;
    $('marks-list').replaceChildren(...list.map(mark => {
      const remove = element('button', { textContent: '×', title: 'Remove this mark' });
      remove.onclick = () => act({ do: 'unmark', line: mark.line });
      const cells = [mark.output, `${mark.x}, ${mark.y}`, `${mark.azimuth.toFixed(2)}°, ${mark.elevation.toFixed(2)}°`, remove];
      return element('tr', {}, ...cells.map(cell => element('td', {}, cell)));
    }));
    drawPad();
  }
  $('mark-solve').disabled = list.length === 0;
}

// Moves the crosshair to the pointer. Moves during a request are sent afterwards.
async function moveCursor(x, y) {
  const output = markOutput();
  if (!output) return;
  const inside = (value, end) => Math.min(Math.max(Math.floor(value), 0), end - 1) + 0.5;
  [cursor.x, cursor.y] = [inside(x, output.size[0]), inside(y, output.size[1])];
  $('mark-place').textContent = `${cursor.x}, ${cursor.y}`;
  drawPad();
  cursor.wanted = true;
  if (cursor.sending) return;
  cursor.sending = true;
  while (cursor.wanted) {
    cursor.wanted = false;
    const name = $('mark-output').value;
    await act({ do: 'pattern', parts: [], only: name, cursor: { output: name, x: cursor.x, y: cursor.y } });
  }
  cursor.sending = false;
}

function drawPad() {
  const output = markOutput(), pad = $('mark-pad');
  if (!output) return;
  const height = Math.round(pad.width * output.size[1] / output.size[0]), context = pad.getContext('2d');
  if (pad.height !== height) pad.height = height;
  const scale = pad.width / output.size[0];
  context.fillStyle = '#000';
  context.fillRect(0, 0, pad.width, height);
  context.fillStyle = '#6cf';
  for (const mark of page.state.marks.list) {
    if (mark.output === output.name) context.fillRect(mark.x * scale - 3, mark.y * scale - 3, 6, 6);
  }
  context.fillStyle = '#fff';
  context.fillRect(0, cursor.y * scale, pad.width, 1);
  context.fillRect(cursor.x * scale, 0, 1, height);
}

$('mark-output').onchange = () => { const output = markOutput(); if (output) moveCursor(output.size[0] / 2, output.size[1] / 2); };
$('mark-show').onclick = () => { $('mark-pad').focus(); $('mark-output').onchange(); };
$('mark-off').onclick = () => act({ do: 'pattern', parts: [] });
{
  const pad = $('mark-pad');
  const follow = event => {
    const output = markOutput(), box = pad.getBoundingClientRect();
    if (output) moveCursor((event.clientX - box.left) / box.width * output.size[0], (event.clientY - box.top) / box.height * output.size[1]);
  };
  pad.onpointerdown = event => { pad.setPointerCapture(event.pointerId); pad.focus(); follow(event); };
  pad.onpointermove = event => { if (event.buttons) follow(event); };
  pad.onkeydown = event => {
    const step = event.shiftKey ? 10 : event.altKey ? 100 : 1;
    const by = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
    if (by) { event.preventDefault(); moveCursor(cursor.x + by[0], cursor.y + by[1]); }
    if (event.key === 'Enter') $('mark-store').click();
  };
}
$('mark-store').onclick = async () => {
  const angle = id => Number($(id).value), name = $('mark-output').value;
  const { x, y } = cursor;
  if (await act({ do: 'mark', output: name, x, y, azimuth: angle('mark-azimuth'), elevation: angle('mark-elevation') })) say(`Mark of ${name} at ${x}, ${y}.`, true);
};
$('mark-solve').onclick = async () => {
  const parts = [...document.querySelectorAll('[data-solve]')].filter(box => box.checked).map(box => box.dataset.solve);
  try {
    const state = await command({ do: 'solve', parts });
    take(state);
    $('mark-solved').textContent = state.solved.join('\n');
  } catch (error) { say(error.message); }
};
