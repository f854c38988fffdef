// Draws lit triangle meshes, lines and points in WebGL 2: all that the pages need.
const vertexShader = `#version 300 es
in vec3 position; in vec3 normal; in mat4 place; in vec4 tint;
uniform mat4 view, projection;
out vec3 lit; out vec4 color;
void main() {
  vec4 seen = view * place * vec4(position, 1);
  lit = mat3(view) * mat3(place) * normal;
  color = tint;
  gl_Position = projection * seen;
  gl_PointSize = 10.0;
}`;
const pixelShader = `#version 300 es
precision mediump float;
in vec3 lit; in vec4 color; out vec4 seen;
void main() {
  float length2 = dot(lit, lit);
  float light = length2 > 0.0 ? 0.35 + 0.65 * abs(lit.z) * inversesqrt(length2) : 1.0;
  seen = vec4(color.rgb * light * color.a, color.a);
}`;

export class Painter {
  constructor(canvas) {
    const gl = (this.gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true }));
    if (!gl) throw new Error('this browser has no WebGL 2');
    this.canvas = canvas;
    const program = (this.program = gl.createProgram());
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, pixelShader]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    ['position', 'normal', 'place', '', '', '', 'tint'].forEach((name, i) => name && gl.bindAttribLocation(program, i, name));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    this.view = gl.getUniformLocation(program, 'view');
    this.projection = gl.getUniformLocation(program, 'projection');
  }
  /** Something to draw: positions, in metres, and normals; null: not lit. */
  shape(positions, normals = null, mode = 'TRIANGLES') {
    const gl = this.gl, made = { array: gl.createVertexArray(), count: positions.length / 3, mode: gl[mode], buffers: [] };
    gl.bindVertexArray(made.array);
    [positions, normals].forEach((numbers, i) => {
      if (!numbers) return;
      const buffer = gl.createBuffer();
      made.buffers.push(buffer);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(numbers), gl.STATIC_DRAW);
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 0, 0);
    });
    // For each instance: a matrix and a colour.
    made.instances = gl.createBuffer();
    made.buffers.push(made.instances);
    gl.bindBuffer(gl.ARRAY_BUFFER, made.instances);
    for (let k = 0; k < 5; ++k) {
      gl.enableVertexAttribArray(2 + k);
      gl.vertexAttribPointer(2 + k, 4, gl.FLOAT, false, 80, 16 * k);
      gl.vertexAttribDivisor(2 + k, 1);
    }
    return made;
  }
  free(shape) {
    if (!shape) return;
    for (const buffer of shape.buffers) this.gl.deleteBuffer(buffer);
    this.gl.deleteVertexArray(shape.array);
  }
  begin(view, background) {
    const gl = this.gl, ratio = Math.min(globalThis.devicePixelRatio ?? 1, 2);
    const [wide, high] = [Math.round(this.canvas.clientWidth * ratio), Math.round(this.canvas.clientHeight * ratio)];
    if (this.canvas.width !== wide || this.canvas.height !== high) [this.canvas.width, this.canvas.height] = [wide, high];
    gl.viewport(0, 0, wide, high);
    gl.clearColor(...background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(this.program);
    gl.uniformMatrix4fv(this.view, false, view);
    const f = 1.8, near = 0.05, far = 500, aspect = wide / high, narrow = Math.min(1, aspect);
    gl.uniformMatrix4fv(this.projection, false,
      [f * narrow / aspect, 0, 0, 0, 0, f * narrow, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0]);
  }
  /** Draws instances: 20 numbers each, a matrix and a colour with its opacity. */
  draw(shape, instances, { above = false } = {}) {
    if (!shape || shape.count === 0 || instances.length === 0) return;
    const gl = this.gl;
    gl.bindVertexArray(shape.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, shape.instances);
    gl.bufferData(gl.ARRAY_BUFFER, instances instanceof Float32Array ? instances : Float32Array.from(instances), gl.DYNAMIC_DRAW);
    const clear = instances[19] < 1;
    if (clear) gl.enable(gl.BLEND), gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA), gl.depthMask(false);
    if (above) gl.disable(gl.DEPTH_TEST);
    gl.drawArraysInstanced(shape.mode, 0, shape.count, instances.length / 20);
    gl.disable(gl.BLEND), gl.depthMask(true), gl.enable(gl.DEPTH_TEST);
  }
}

/** Corners and flat normals of triangles: { positions, normals }. */
export function facets(vertices, faces) {
  const positions = new Float32Array(3 * faces.length), normals = new Float32Array(3 * faces.length);
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => vertices.subarray(3 * faces[i + k], 3 * faces[i + k] + 3));
    const u = [0, 1, 2].map((k) => b[k] - a[k]), v = [0, 1, 2].map((k) => c[k] - a[k]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const size = Math.hypot(...n) || 1;
    [a, b, c].forEach((corner, k) => {
      positions.set(corner, 3 * (i + k));
      normals.set(n.map((number) => number / size), 3 * (i + k));
    });
  }
  return { positions, normals };
}

/** A camera that turns around the origin. */
export class Orbit {
  turn = 0.6;
  tilt = 0.35;
  constructor(distance) { this.distance = distance; }
  get axes() {
    const [s, c, t, d] = [Math.sin(this.turn), Math.cos(this.turn), Math.sin(this.tilt), Math.cos(this.tilt)];
    return { right: [c, s, 0], up: [s * t, -c * t, d], back: [s * d, -c * d, t] };
  }
  get view() {
    const { right: r, up: u, back: b } = this.axes;
    return [r[0], u[0], b[0], 0, r[1], u[1], b[1], 0, r[2], u[2], b[2], 0, 0, 0, -this.distance, 1];
  }
  drag(dx, dy) {
    this.turn -= 0.008 * dx;
    this.tilt = Math.max(-1.5, Math.min(1.5, this.tilt + 0.008 * dy));
  }
}

/** Calls move(dx, dy, pointers, event), in pixels, while the mouse or fingers drag on an element; `pointers` are down. */
export function onDrag(element, move) {
  const places = new Map();
  element.addEventListener('pointerdown', (event) => {
    element.setPointerCapture(event.pointerId);
    places.set(event.pointerId, [event.clientX, event.clientY]);
  });
  element.addEventListener('pointermove', (event) => {
    const last = places.get(event.pointerId);
    if (!last) return;
    places.set(event.pointerId, [event.clientX, event.clientY]);
    move(event.clientX - last[0], event.clientY - last[1], places.size, event);
  });
  for (const name of ['pointerup', 'pointercancel']) element.addEventListener(name, (event) => places.delete(event.pointerId));
}
