// The dome in three dimensions: outputs as meshes on the screen, whose light adds up.
'use strict';

class Dome {
  constructor(canvas, labels) {
    this.canvas = canvas;
    this.labels = labels;
    this.place = 'outside';
    this.orbit = { yaw: 0.55, pitch: 0.42, distance: 2.6 };
    this.look = { yaw: 0, pitch: 0.35, fov: 1.3 };
    this.seat = 'viewer';
    this.overlay = 'picture';
    this.frusta = this.lines = true;
    this.selected = null;
    // Returns yaw, pitch and width of the panel while it is dragged.
    this.panel = null;
    this.rects = {};
    // True if moving pictures have fewer triangles.
    this.coarse = false;
    // Part of the width that is painted, times of the paints since it was chosen, and the picture to paint.
    [this.share, this.paints, this.came, this.told] = [1, [], null, []];
    this.start();
    canvas.addEventListener('webglcontextlost', event => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => { this.start(); if (this.data) this.setScene(this.data); });
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  start() {
    const gl = this.gl = this.canvas.getContext('webgl2', { antialias: false, alpha: false });
    if (!gl) throw new Error('This browser has no WebGL 2: the dome cannot be shown. The outputs beside it can.');
    const program = (vertex, fragment) => {
      const made = gl.createProgram();
      for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
        gl.attachShader(made, shader);
      }
      ['point', 'uv', 'value'].forEach((name, place) => gl.bindAttribLocation(made, place, name));
      gl.linkProgram(made);
      const at = {};
      for (let i = 0; i < (gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS) || 0); i++) {
        const { name } = gl.getActiveUniform(made, i);
        at[name] = gl.getUniformLocation(made, name);
      }
      return { made, at };
    };
    // A program for each mode: some drivers compute all branches of a shader.
    const meshes = [];
    this.meshesOf = mode => meshes[mode] ||= program(VERTEX, FRAGMENT.replace('MODE', mode));
    this.strokes = program(FLAT, PLAIN);
    this.show = program(WHOLE, SHOW);
    this.frame = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.frame);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) {
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    }
    this.light = null;
    this.outputs = [];
    this.stroke = gl.createBuffer();
    this.grid = { buffer: gl.createBuffer(), count: 0 };
    this.size = 1;
  }

  // Linear values are added: blending to an sRGB image is linear.
  lightOf(width, height) {
    const gl = this.gl;
    if (this.light && this.light.width === width && this.light.height === height) return this.light;
    if (this.light) { gl.deleteTexture(this.light.texture); gl.deleteFramebuffer(this.light.target); }
    const texture = gl.createTexture(), target = gl.createFramebuffer();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.SRGB8_ALPHA8, width, height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    return this.light = { texture, target, width, height };
  }

  setScene(data) {
    const gl = this.gl;
    this.data = data;
    const kept = new Map(this.outputs.map(old => [old.mesh, old]));
    this.outputs = data.outputs.map(output => {
      const same = kept.get(output.mesh);
      if (same) { kept.delete(output.mesh); return { ...same, name: output.name }; }
      const array = gl.createVertexArray(), buffers = [];
      gl.bindVertexArray(array);
      const give = (at, size, values) => {
        const buffer = gl.createBuffer();
        buffers.push(buffer);
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
        gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
        gl.enableVertexAttribArray(at);
        gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
        return buffer;
      };
      give(0, 3, output.points);
      give(1, 2, output.uv);
      const values = give(2, 1, new Float32Array(output.uv.length / 2).fill(1));
      const indices = gl.createBuffer();
      buffers.push(indices);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
      const { triangles, coarse } = output;
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles.byteLength + coarse.byteLength, gl.STATIC_DRAW);
      gl.bufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, triangles);
      gl.bufferSubData(gl.ELEMENT_ARRAY_BUFFER, triangles.byteLength, coarse);
      gl.bindVertexArray(null);
      return { name: output.name, mesh: output.mesh, array, buffers, values, count: triangles.length, coarse: coarse.length };
    });
    for (const old of kept.values()) { gl.deleteVertexArray(old.array); old.buffers.forEach(b => gl.deleteBuffer(b)); }
    const ends = data.lines.flatMap(line => { const pairs = []; for (let i = 0; i + 5 < line.length; i += 3) pairs.push(...line.slice(i, i + 6)); return pairs; });
    gl.bindBuffer(gl.ARRAY_BUFFER, this.grid.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(ends), gl.STATIC_DRAW);
    this.grid.count = ends.length / 3;
    this.size = Math.max(data.size, data.radius) || 1;
    this.values = null;
    this.draw();
  }

  setValues(values) {
    const gl = this.gl;
    values.forEach((list, index) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.outputs[index].values);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(list.map(v => v === null ? -1 : v)), gl.DYNAMIC_DRAW);
    });
    const all = values.flat().filter(v => v !== null).sort((a, b) => a - b);
    this.values = { least: all[0] || 0, greatest: all[Math.floor(all.length * 0.995)] || 1 };
    this.draw();
  }

  setFrame(bitmap, rects) {
    this.came = { bitmap, rects };
    this.draw();
  }

  // Sends the latest picture to the graphics card when it is painted.
  takeFrame() {
    if (!this.came) return;
    const gl = this.gl, { bitmap, rects } = this.came;
    gl.bindTexture(gl.TEXTURE_2D, this.frame);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    [this.side, this.rects, this.came] = [bitmap.width, rects, null];
  }

  seatPoint() {
    const { radius, viewer } = this.data, [x, y, z] = viewer.position, part = 0.5 * radius;
    return { viewer: [x, y, z], front: [x, y, z - part], back: [x, y, z + part], left: [x - part, y, z], right: [x + part, y, z], centre: [0, 0, 0] }[this.seat];
  }

  // Position of the eye, matrix of the camera, and its axes.
  camera() {
    const aspect = this.canvas.width / this.canvas.height || 1;
    let eye, forward, fov;
    if (this.place === 'outside') {
      const { yaw, pitch, distance } = this.orbit, far = distance * this.size;
      const middle = [0, 0.3 * this.size, 0];
      const away = [Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch)];
      eye = add(middle, scale(away, far));
      forward = scale(away, -1);
      fov = 0.9;
    } else {
      const { yaw, pitch } = this.look;
      eye = this.seatPoint();
      forward = [Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), -Math.cos(yaw) * Math.cos(pitch)];
      fov = this.look.fov;
    }
    const right = unit(cross(forward, [0, 1, 0])), up = cross(right, forward);
    const half = Math.tan(fov / 2), f = 1 / (aspect < 1 ? half / aspect : half), near = 0.01 * this.size, far = 60 * this.size;
    const a = -(far + near) / (far - near), b = -2 * far * near / (far - near);
    const rows = [[...scale(right, f / aspect), -dot(right, eye) * f / aspect], [...scale(up, f), -dot(up, eye) * f],
      [...scale(forward, -a), dot(forward, eye) * a + b], [...forward, -dot(forward, eye)]];
    const matrix = new Float32Array(16);
    rows.forEach((row, r) => row.forEach((v, c) => { matrix[4 * c + r] = v; }));
    return { eye, forward, matrix, rows };
  }

  // Paints soon, but not before the graphics card has finished the last paint: queued pictures would be old ones.
  draw() {
    this.wanted = true;
    if (this.busy) return;
    this.busy = true;
    requestAnimationFrame(() => {
      this.wanted = false;
      this.paint();
      const gl = this.gl, fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), begun = performance.now();
      gl.flush();
      const look = () => {
        const past = performance.now() - begun;
        const isDone = past > 1000 || gl.isContextLost() || gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED;
        if (!isDone) { setTimeout(look, 2); return; }
        gl.deleteSync(fence);
        this.busy = false;
        this.adapt(past);
        if (this.wanted) this.draw();
        else this.told.splice(0).forEach(tell => tell());
      };
      setTimeout(look, 0);
    });
  }

  // Waits until the requested paint is done, but not for long: a hidden page is not painted.
  isPainted() {
    if (!this.busy) return Promise.resolve();
    return new Promise(done => { this.told.push(done); setTimeout(done, 300); });
  }

  // On slow graphics, moving pictures have fewer triangles and pixels. When nothing moves any more, all are painted.
  adapt(milliseconds) {
    clearTimeout(this.rest);
    if (!this.whole) {
      this.paints.push(milliseconds);
      if (this.share < 1 || this.coarse) this.rest = setTimeout(() => { this.whole = true; this.draw(); }, 400);
    }
    this.whole = false;
    if (this.paints.length < 3) return;
    const median = this.paints.sort((a, b) => a - b)[1];
    this.paints = [];
    if (median > 40 && !this.coarse) this.coarse = true;
    else if (median > 40) this.share = Math.max(this.share * 0.7, 0.34);
    else if (median < 14) this.share = Math.min(this.share / 0.7, 1);
  }

  paint() {
    const gl = this.gl, canvas = this.canvas, dense = Math.min(devicePixelRatio || 1, 2) * (this.whole ? 1 : this.share);
    const width = Math.round(canvas.clientWidth * dense), height = Math.round(canvas.clientHeight * dense);
    if (!this.data || !width || !height || gl.isContextLost()) return;
    this.takeFrame();
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const light = this.lightOf(width, height), camera = this.camera();
    gl.bindFramebuffer(gl.FRAMEBUFFER, light.target);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    this.paintOutputs(camera);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.disable(gl.BLEND);
    gl.useProgram(this.show.made);
    gl.bindTexture(gl.TEXTURE_2D, light.texture);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    this.paintLines(camera);
    this.placeLabels(camera);
    this.painted = (this.painted || 0) + 1;
  }

  range() {
    if (this.overlay === 'error') return [0, 30];
    if (!this.values) return [0, 1];
    if (this.overlay === 'light') return [0, Math.max(1.25, this.values.greatest)];
    return [0, this.values.greatest * 1.02];
  }

  paintOutputs(camera) {
    const gl = this.gl;
    const hasPicture = Object.keys(this.rects).length > 0;
    const overlay = this.values || this.overlay === 'error' ? this.overlay : 'picture';
    const mode = { picture: hasPicture ? 0 : 1, error: 2, coverage: 3 }[overlay] ?? 4;
    const { made, at } = this.meshesOf(mode);
    gl.useProgram(made);
    gl.uniformMatrix4fv(at.camera, false, camera.matrix);
    gl.uniform3fv(at.eye, this.place === 'outside' && mode === 2 ? this.seatPoint() : camera.eye);
    gl.uniform3fv(at.viewer, this.data.viewer.position);
    gl.uniform2fv(at.range, this.range());
    gl.uniform1f(at.tilt, this.data.tilt * Math.PI / 180);
    gl.bindTexture(gl.TEXTURE_2D, this.frame);
    // Moving pictures have fewer triangles where graphics are slow. Values need all vertices.
    const isCoarse = this.coarse && !this.whole && mode < 2;
    // Light adds up; values do not.
    if (mode < 2) { gl.enable(gl.BLEND); gl.blendFunc(gl.ONE, gl.ONE); } else gl.disable(gl.BLEND);
    for (const output of this.outputs) {
      const rect = this.rects[output.name];
      if (mode === 0 && !rect) continue;
      const side = this.side || 1;
      gl.uniform4fv(at.rect, rect ? rect.map(v => v / side) : [0, 0, 1, 1]);
      gl.uniform1f(at.texel, 1 / side);
      gl.uniform1f(at.seen, this.only && this.only !== output.name ? 0.15 : 1);
      gl.bindVertexArray(output.array);
      const [first, count] = isCoarse ? [output.count, output.coarse] : [0, output.count];
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * first);
    }
    gl.bindVertexArray(null);
  }

  strokeAll(points, kind, paint) {
    const gl = this.gl;
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points), gl.STREAM_DRAW);
    gl.uniform4fv(this.strokes.at.paint, paint);
    gl.drawArrays(kind, 0, points.length / 3);
  }

  paintLines(camera) {
    const gl = this.gl;
    gl.useProgram(this.strokes.made);
    gl.uniformMatrix4fv(this.strokes.at.camera, false, camera.matrix);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.stroke);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    if (this.lines) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.grid.buffer);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
      gl.uniform4fv(this.strokes.at.paint, [0.5, 0.6, 0.75, this.place === 'outside' ? 0.3 : 0.16]);
      gl.drawArrays(gl.LINES, 0, this.grid.count);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.stroke);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    }
    if (this.frusta) {
      for (const output of this.data.outputs) {
        const on = output.name === this.selected, paint = on ? [0.95, 0.68, 0.2, 0.95] : [0.75, 0.75, 0.75, 0.28];
        const corners = output.frustum;
        if (output.projector && output.origin && this.place === 'outside') {
          const rays = [];
          for (let i = 0; i < corners.length; i += 3) rays.push(...output.origin, ...corners.slice(i, i + 3));
          this.strokeAll(rays, gl.LINES, paint);
        }
        if (on) this.strokeAll(this.border(output), gl.LINES, paint);
      }
      if (this.place === 'outside') {
        const p = this.data.viewer.position, s = 0.03 * this.size, f = add(p, scale(this.data.viewer.forward, 0.18 * this.size));
        this.strokeAll([...p, ...f, ...add(p, [s, 0, 0]), ...add(p, [-s, 0, 0]), ...add(p, [0, s, 0]), ...add(p, [0, -s, 0])], gl.LINES, [0.4, 0.9, 0.5, 0.9]);
      }
    }
    if (this.panel) this.strokeAll(this.panelLines(), gl.LINES, [0.95, 0.68, 0.2, 0.95]);
    gl.disableVertexAttribArray(0);
  }

  // Outline of the panel, half a radius in front of the viewer, with the height of a window of 16:9.
  panelLines() {
    const { position, forward } = this.data.viewer, right = unit(cross(forward, [0, 1, 0])), up = cross(right, forward);
    const [yaw, pitch, width] = this.panel().map(degrees => degrees * Math.PI / 180), far = 0.5 * this.size;
    const ahead = add(scale(right, Math.sin(yaw)), scale(forward, Math.cos(yaw)));
    const middle = add(position, scale(add(scale(ahead, Math.cos(pitch)), scale(up, Math.sin(pitch))), far));
    const half = Math.min(Math.tan(width / 2), 3) * far;
    const across = scale(sub(scale(right, Math.cos(yaw)), scale(forward, Math.sin(yaw))), half);
    const high = scale(sub(scale(up, Math.cos(pitch)), scale(ahead, Math.sin(pitch))), half * 9 / 16);
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => add(middle, add(scale(across, x), scale(high, y))));
    return corners.flatMap((corner, index) => [...corner, ...corners[(index + 1) % 4]]);
  }

  // Edges of a mesh that belong to one triangle only.
  border(output) {
    if (output.edge) return output.edge;
    const seen = new Map(), points = [];
    for (let t = 0; t < output.triangles.length; t += 3) for (let i = 0; i < 3; i++) {
      const a = output.triangles[t + i], b = output.triangles[t + (i + 1) % 3], key = a < b ? a * 65536 + b : b * 65536 + a;
      seen.set(key, seen.has(key) ? null : [a, b]);
    }
    for (const edge of seen.values()) if (edge) for (const v of edge) points.push(...output.points.slice(3 * v, 3 * v + 3));
    return output.edge = points;
  }

  project(point, rows) {
    const [x, y, , w] = rows.map(row => row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + row[3]);
    return w > 0 ? [(0.5 + 0.5 * x / w) * this.canvas.clientWidth, (0.5 - 0.5 * y / w) * this.canvas.clientHeight] : null;
  }

  placeLabels(camera) {
    const wanted = this.frusta ? this.data.outputs.filter(o => o.projector && o.origin && this.place === 'outside') : [];
    while (this.labels.childElementCount > wanted.length) this.labels.lastChild.remove();
    wanted.forEach((output, index) => {
      const label = this.labels.children[index] || this.labels.appendChild(document.createElement('span'));
      const at = this.project(output.origin, camera.rows);
      if (label.textContent !== output.name) label.textContent = output.name;
      label.className = output.name === this.selected ? 'on' : '';
      label.style.display = at ? '' : 'none';
      if (at) { label.style.left = `${at[0]}px`; label.style.top = `${at[1]}px`; }
    });
  }
}
