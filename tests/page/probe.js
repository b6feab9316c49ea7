// Measurements for scripts/page in the page of `cupola serve`: brightness of each picture, and times.
'use strict';
window.probe = (() => {
  const small = Object.assign(document.createElement('canvas'), { width: 64, height: 64 });
  const context = small.getContext('2d', { willReadFrequently: true });
  const probe = { pictures: [], input: 0, waitsFor: null };

  // Mean brightness of a received picture, 0 to 255.
  function brightness(bitmap) {
    context.clearRect(0, 0, 64, 64);
    context.drawImage(bitmap, 0, 0, 64, 64);
    const { data } = context.getImageData(0, 0, 64, 64);
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
    return sum / (3 * 64 * 64);
  }

  // Each picture is recorded after it was painted on the dome.
  const { setFrame, paint } = Dome.prototype;
  let pending = null;
  Dome.prototype.setFrame = function (bitmap, rects) {
    setFrame.call(this, bitmap, rects);
    pending = { mean: brightness(bitmap), came: performance.now() };
  };
  Dome.prototype.paint = function () {
    paint.call(this);
    if (probe.painted) probe.painted(this);
    if (!pending) return;
    probe.pictures.push({ ...pending, painted: performance.now() });
    pending = null;
    const last = probe.pictures[probe.pictures.length - 1], wanted = probe.waitsFor;
    if (!wanted || !probe.input || !wanted.test(last.mean)) return;
    probe.waitsFor = null;
    // The picture is painted when the browser's GPU has finished.
    const { gl } = this, fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED ? wanted.done(performance.now() - probe.input) : setTimeout(look, 1);
    look();
  };
  addEventListener('input', () => { probe.input ||= performance.now(); }, true);

  const sleep = milliseconds => new Promise(done => setTimeout(done, milliseconds));
  const median = list => [...list].sort((a, b) => a - b)[list.length >> 1];

  // Brightness of the next pictures, after the pictures that are already sent.
  probe.settle = async () => {
    await sleep(600);
    const first = probe.pictures.length;
    for (let i = 0; i < 300 && probe.pictures.length < first + 5; i++) await sleep(50);
    const means = probe.pictures.slice(first).map(picture => picture.mean);
    if (!means.length) throw new Error('no picture came within 15 s');
    return median(means);
  };

  // Milliseconds from the next input event to the first painted picture on the other side of `threshold`.
  probe.change = (threshold, brighter) => new Promise((done, failed) => {
    probe.input = 0;
    probe.waitsFor = { test: mean => brighter ? mean > threshold : mean < threshold, done };
    setTimeout(() => failed(new Error('no changed picture within 15 s')), 15000);
  });

  // Stages of the next change by a slider, in milliseconds from the input event: the server's answer, the places of the
  // light, the first picture of the changed rig, and when both are painted.
  probe.stages = () => new Promise((done, failed) => {
    probe.input = 0;
    const stages = {}, since = () => Math.round(performance.now() - probe.input);
    const limit = setTimeout(() => failed(new Error(`no changed picture within 15 s: ${JSON.stringify(stages)}`)), 15000);
    let version = null;
    const take0 = take;
    take = state => { take0(state); if (probe.input && version === null && sending) { version = state.version; stages.answer = since(); } };
    probe.painted = dome => {
      if (version === null) return;
      if (page.sceneVersion >= version) stages.scene ??= since();
      if (page.pictureVersion >= version) stages.picture ??= Math.round(page.lastFrame - probe.input);
      if (stages.scene === undefined || stages.picture === undefined) return;
      probe.painted = null;
      take = take0;
      clearTimeout(limit);
      probe.finished(dome.gl).then(() => done({ ...stages, painted: since() }));
    };
  });

  // Waits until the browser's graphics have finished all paints.
  probe.finished = gl => new Promise(done => {
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED ? done() : setTimeout(look, 1);
    look();
  });

  // Part of a slider's width at which a click sets it to a value.
  probe.partOf = (selector, value) => {
    const { min, max, clientWidth } = document.querySelector(selector), thumb = 16;
    const part = (value - min) / (max - min);
    return (thumb / 2 + part * (clientWidth - thumb)) / clientWidth;
  };

  // Part of the pixels of the painted dome that are not dark.
  probe.litPixels = () => {
    const { gl, canvas } = page.dome;
    page.dome.paint();
    const bytes = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    let lit = 0;
    for (let i = 0; i < bytes.length; i += 4) if (Math.max(bytes[i], bytes[i + 1], bytes[i + 2]) > 40) lit++;
    return lit / (bytes.length / 4);
  };

  // Colors of the painted dome's pixels, which the visitor gets one after the other. Projectors and lines are left out.
  const visit = async visitor => {
    const { dome } = page, { gl, canvas } = dome, [frusta, lines] = [dome.frusta, dome.lines];
    [dome.frusta, dome.lines, dome.whole] = [false, false, true];
    dome.paint();
    const bytes = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    [dome.frusta, dome.lines] = [frusta, lines];
    for (let i = 0; i < bytes.length; i += 4) if (Math.max(bytes[i], bytes[i + 1], bytes[i + 2]) > 10) visitor(bytes[i], bytes[i + 1], bytes[i + 2]);
  };

  // Values of the chosen overlay, and whether the painted dome has its colors.
  probe.values = async () => {
    const { values } = await (await ask(`/overlay?kind=${document.getElementById('overlay').value}`)).json();
    const all = values.flat().filter(value => value !== null).sort((a, b) => a - b);
    // Overlaps are grey and green; values go from blue to red. A picture of glxgears is neither.
    let lit = 0, right = 0;
    const isCoverage = page.dome.overlay === 'coverage';
    await visit((red, green, blue) => {
      lit++;
      const isGrey = Math.abs(red - green) < 4 && Math.abs(green - blue) < 4;
      // One channel is full, or the only one.
      const [, second, most] = [red, green, blue].sort((a, b) => a - b);
      const isRamp = Math.abs(most - 230) < 6 || second < 20 && most > 150;
      if (isCoverage ? isGrey || green > 1.2 * blue : isRamp) right++;
    });
    return {
      least: all[0], median: median(all), greatest: all[all.length - 1], different: [...new Set(all)].slice(0, 9),
      legend: document.getElementById('legend').textContent, isPainted: page.dome.values !== null && lit > 1000 && right > 0.9 * lit,
    };
  };

  // Part of the dome that is painted as without an error.
  probe.errorFree = async () => {
    let lit = 0, free = 0;
    await visit((red, green, blue) => { lit++; if (red < 4 && green < 60 && blue > 100) free++; });
    return free / lit;
  };

  // Number of pixels in the color of the selected projector and of the panel.
  probe.marked = () => {
    const { gl, canvas } = page.dome;
    page.dome.paint();
    const bytes = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    let marked = 0;
    for (let i = 0; i < bytes.length; i += 4) if (bytes[i] > 200 && Math.abs(bytes[i + 1] - 0.72 * bytes[i]) < 20 && bytes[i + 2] < 0.4 * bytes[i]) marked++;
    return marked;
  };

  // Keys whose controls are visible.
  probe.shownKeys = () => [...document.querySelectorAll('#keys .key')].filter(row => row.checkVisibility()).map(row => row.dataset.key);

  // Keys that have no control, or one that is not visible, when all sections are open.
  probe.keysWithoutControl = async () => {
    for (let round = 0; round < 3; round++) {
      document.querySelectorAll('#keys details').forEach(section => { section.open = true; });
      await sleep(200);
    }
    const shown = new Set(probe.shownKeys());
    const found = (await command({ do: 'keys' })).map(key => key.key).filter(key => !shown.has(key));
    document.querySelectorAll('#keys details').forEach(section => { section.open = false; });
    await sleep(200);
    return found;
  };

  // Names and brightness of the pictures in the tab of outputs.
  probe.outputs = () => [...document.querySelectorAll('#outputs .output')].map(box => ({ name: box.dataset.name, mean: brightness(box.querySelector('canvas')) }));

  // Pseudo-random numbers that are the same in each run.
  let seed = 12345;
  const random = () => { seed = (Math.imul(seed, 1103515245) + 12345) >>> 0; return seed / 4294967296; };
  const one = list => list[Math.floor(random() * list.length)];

  // Random changes of keys. Every second change is wrong. The right changes move the picture only a little.
  probe.edits = async count => {
    // All changes are near the first values, so that the memory of later rigs is comparable.
    probe.firstKeys ??= await command({ do: 'keys' });
    const start = probe.firstKeys;
    const near = (value, by) => Array.isArray(value) ? `[${value.map(each => (each + by * (2 * random() - 1)).toFixed(4)).join(', ')}]` : value + by * (2 * random() - 1);
    // Kinds of keys, with a value near the first one.
    const kinds = [
      [/^output\..*\.(yaw|pitch|roll)$|^(viewer|overlay|camera)\.(yaw|pitch|roll)$|^dome\.tilt$/, key => near(key.value ?? 0, 3)],
      [/^output\.[^.]*\.position$|^viewer\.position$/, key => near(key.value ?? [0, 0, 0], 0.1)],
      [/^output\.[^.]*\.fov$/, key => near(key.value, 2)],
      [/\.shift$/, () => near([0, 0], 0.05)],
      [/\.distortion\.radial$/, () => near([0, 0, 0], 0.001)],
      [/^dome\.radius$/, key => near(key.value, 0.1)],
      [/^dome\.coverage$/, () => 170 + 10 * random()],
      [/gamma$/, () => 1.8 + random()],
      [/ramp$/, () => 0.05 + 0.4 * random()],
      [/blend\.contrast$/, () => 500 + 2000 * random()],
      [/even_light$/, () => 0.1 * random()],
      [/^overlay\.width$/, () => 40 + 20 * random()],
      [/^views\.quality$/, () => 0.5 + random()],
    ];
    const kindOf = key => kinds.find(([name]) => name.test(key.key));
    const gentle = start.filter(key => key.type === 'number' && kindOf(key));
    const right = key => kindOf(key)[1](key);
    const wrong = () => one([
      () => `${one(gentle).key}=${one(['1e300', '-1e300', 'nan', '"text"', '[1, 2', '', 'true', '{ a = 1 }'])}`,
      () => `output.nobody.yaw=${random()}`,
      () => `dome.radius=${-random()}`,
      () => `${one(['dome.radios', 'x', '', '=', 'output', 'output[99].yaw', 'a'.repeat(5000)])}=1`,
      () => `viewer.position=[${1000 * random() + 100}, 0, 0]`,
      () => `views.quality=${one([0, -1, 1e9])}`,
    ])();
    const found = { accepted: 0, refused: 0, wrongAccepted: [], rightRefused: [], changedByWrong: 0 };
    const firstPicture = probe.pictures.length;
    for (let i = 0; i < count; i++) {
      const key = one(gentle), isRight = i % 2 === 0, change = isRight ? `${key.key}=${right(key)}` : wrong();
      const { version } = page.state;
      try {
        const state = await command({ do: 'set', changes: [change] });
        take(state);
        found.accepted++;
        if (!isRight) found.wrongAccepted.push(change.slice(0, 80));
      } catch (error) {
        found.refused++;
        if (isRight) found.rightRefused.push(`${change}: ${error.message}`.slice(0, 300));
        if ((await command({ do: 'state' })).version !== version) found.changedByWrong++;
      }
      // Waits, since a person is not faster.
      await sleep(15);
    }
    const means = probe.pictures.slice(firstPicture).map(picture => picture.mean);
    return { ...found, pictures: means.length, darkest: Math.min(...means), median: median(means) };
  };

  // Requests with random content. Only well-formed requests may be accepted.
  probe.fuzz = async count => {
    const words = ['do', 'set', 'undo', 'pattern', 'start', 'rig', 'save', 'keys', 'state', 'changes', 'remove', 'name', 'program', 'command', 'parts', 'at', 'step', 'only'];
    const value = depth => one([() => null, () => random() * 1e9, () => one(words), () => '\u0000\ud800', () => -1, () => true, () => 'x'.repeat(3000 * random()),
      () => depth ? [value(depth - 1), value(depth - 1)] : [], () => depth ? Object.fromEntries([1, 2, 3].map(() => [one(words), value(depth - 1)])) : {}])();
    const statuses = {};
    for (let i = 0; i < count; i++) {
      const kind = i % 4;
      const body = kind === 0 ? JSON.stringify(value(3)) : kind === 1 ? JSON.stringify({ do: one(['set', 'pattern', 'get', 'nothing', 7]), ...value(0), changes: value(2), parts: value(2), at: value(2), step: value(0) })
        : Array.from({ length: 200 * random() }, () => String.fromCharCode(65536 * random())).join('');
      const path = kind === 3 ? one([`/frame?after=${value(0)}&side=${value(0)}`.slice(0, 400), '/overlay?kind=' + one(words), '/../etc/passwd', '/%00', '/frame?side=99999999999&after=0', '/scene?' + 'a'.repeat(3000)]) : '/do';
      // The server must not wait for a frame that never comes.
      const answer = await fetch(path, { method: kind === 3 ? 'GET' : 'POST', body: kind === 3 ? undefined : body, headers: { 'X-Cupola-Token': token } });
      statuses[answer.status] = (statuses[answer.status] || 0) + 1;
      await answer.arrayBuffer();
    }
    return statuses;
  };
  return probe;
})();
