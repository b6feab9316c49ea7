// Tabs, and what the pointer does in the picture of the dome.
'use strict';

function choose(group, chosen) { for (const button of group) button.classList.toggle('on', button === chosen); }
for (const button of document.querySelectorAll('nav button')) {
  button.onclick = () => {
    choose(document.querySelectorAll('nav button'), button);
    for (const tab of document.querySelectorAll('.tab')) tab.classList.toggle('on', tab.id === button.dataset.tab);
    drawOutputs();
    if (page.state) showHealth(page.state);
  };
}
if (dome) {
  const places = document.querySelectorAll('[data-place]'), drags = document.querySelectorAll('[data-drag]');
  for (const button of places) button.onclick = () => { choose(places, button); dome.place = button.dataset.place; dome.draw(); };
  let drag = 'look';
  for (const button of drags) {
    button.onclick = () => {
      choose(drags, button);
      drag = button.dataset.drag;
      dome.panel = drag === 'panel' ? () => ['yaw', 'pitch', 'width'].map(name => numbersOf(`overlay.${name}`)) : null;
      dome.draw();
    };
  }
  $('seat').onchange = () => { dome.seat = $('seat').value; if (dome.overlay !== 'error') places[1].click(); dome.draw(); };
  $('overlay').onchange = () => showOverlay().catch(error => say(error.message));
  $('frusta').onchange = () => { dome.frusta = $('frusta').checked; dome.draw(); };
  $('lines').onchange = () => { dome.lines = $('lines').checked; dome.draw(); };
  $('labels').onclick = event => {
    const name = event.target.textContent, section = [...$('keys').children].find(one => one.dataset.group === `output.${name}`);
    select(name);
    if (section) { section.open = true; section.scrollIntoView({ block: 'start', behavior: 'smooth' }); }
  };
  const held = new Map(), view = $('view');
  // Each drag is a step of its own.
  let apart = 0, number = 0;
  view.onpointerdown = event => { held.set(event.pointerId, [event.clientX, event.clientY]); view.setPointerCapture(event.pointerId); apart = 0; number++; };
  view.onpointerup = view.onpointercancel = event => { held.delete(event.pointerId); apart = 0; };
  view.onpointermove = event => {
    const last = held.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
    held.set(event.pointerId, [event.clientX, event.clientY]);
    if (held.size === 2) {
      const [a, b] = [...held.values()], now = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (apart) zoom(apart / now);
      apart = now;
    } else if (drag === 'look') turn(dx, dy);
    else dragRig(dx, dy, event.shiftKey);
  };
  view.onwheel = event => { event.preventDefault(); zoom(Math.exp(event.deltaY * 0.0012)); };
  const clamp = (value, least, greatest) => Math.min(Math.max(value, least), greatest);
  const turn = (dx, dy) => {
    if (dome.place === 'outside') {
      dome.orbit.yaw -= dx * 0.006;
      dome.orbit.pitch = clamp(dome.orbit.pitch + dy * 0.006, -1.5, 1.5);
    } else {
      const speed = dome.look.fov / view.clientHeight;
      dome.look.yaw -= dx * speed;
      dome.look.pitch = clamp(dome.look.pitch + dy * speed, -1.5, 1.5);
    }
    dome.draw();
  };
  const zoom = factor => {
    if (dome.place === 'outside') dome.orbit.distance = clamp(dome.orbit.distance * factor, 0.3, 12);
    else dome.look.fov = clamp(dome.look.fov * factor, 0.1, 2.6);
    dome.draw();
  };
  // Value of a key, or what replaces it.
  const numbersOf = key => valueOf(key) ?? keyOf(key)?.default ?? 0;
  const has = key => keyOf(key)?.type === 'number';
  const give = (key, value) => {
    optimistic.set(key, value);
    change(key, Array.isArray(value) ? `[${value.join(', ')}]` : String(value), null, `drag ${number}`);
    fillKey(keyOf(key));
    dome.draw();
  };
  // Turns to the right and upwards, in degrees.
  const aim = (path, dx, dy) => {
    for (const [name, by] of [['yaw', dx], ['pitch', -dy]]) {
      if (has(`${path}.${name}`) && by) give(`${path}.${name}`, tidy(numbersOf(`${path}.${name}`) + by, 0.01));
    }
  };
  // Moves a place seen from above, or up and down.
  const move = (key, dx, dy, isUp) => {
    const [x, y, z] = numbersOf(key), yaw = dome.place === 'outside' ? dome.orbit.yaw : -dome.look.yaw;
    const by = 0.004 * dome.size * ($('fine').checked ? 0.1 : 1), [right, back] = [dx * by, dy * by];
    const moved = isUp ? [x, y - back, z] : [x + right * Math.cos(yaw) + back * Math.sin(yaw), y, z - right * Math.sin(yaw) + back * Math.cos(yaw)];
    give(key, moved.map(v => tidy(v, 0.001)));
  };
  const dragRig = (dx, dy, isUp) => {
    const output = `output.${dome.selected}`, degrees = $('fine').checked ? 0.01 : 0.1;
    if (drag === 'viewer') move('viewer.position', dx, dy, isUp);
    else if (drag === 'panel') aim('overlay', dx * degrees, dy * degrees);
    else if (!dome.selected) say('Select a projector first, by its name.');
    else if (drag === 'aim') aim(output, dx * degrees, dy * degrees);
    else if (has(`${output}.position`)) move(`${output}.position`, dx, dy, isUp);
    else if (!waiting.size) say(`${dome.selected} has no place of its own.`);
  };
}

poll();
pictures();
