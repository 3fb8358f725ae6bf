// Pointers on the canvas: one uses the chosen tool, two move and zoom the picture, and so do the wheel and the right
// button. What a tool does to the world happens before the next step.

const kickSpeed = 8; // m/s a metre of the picture's twentieth

export class Hands {
  constructor(canvas, show) {
    this.canvas = canvas;
    this.show = show; // the world and the camera that are shown
    this.pointers = new Map();
    this.grab = undefined;
    canvas.addEventListener('pointerdown', (e) => this.down(e));
    canvas.addEventListener('pointermove', (e) => this.move(e));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (e) => this.up(e));
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    canvas.addEventListener('wheel', (e) => {
      e.preventDefault();
      show.camera.zoom(Math.exp(-e.deltaY / 500), this.place(e));
    }, { passive: false });
  }

  place(e) { return this.show.camera.toWorld(this.canvas, e.offsetX, e.offsetY); }

  down(e) {
    this.canvas.setPointerCapture(e.pointerId);
    this.pointers.set(e.pointerId, { x: e.offsetX, y: e.offsetY });
    if (this.pointers.size > 1 || e.button !== 0) {
      this.letGo();
      this.pans = true;
      return;
    }
    this.pans = false;
    const [x, y] = this.place(e);
    const { world, tool } = this.show;
    if (tool === 'kick') return this.kick(x, y);
    if (tool === 'grab') {
      const reach = this.show.camera.span[0] / 40;
      this.grab = world.grab(x, y, reach, (id) => this.show.massOf(id));
      this.pans = this.grab === undefined;
      return;
    }
    this.add(tool, x, y);
  }

  move(e) {
    const was = this.pointers.get(e.pointerId);
    if (!was) return;
    const { camera } = this.show;
    if (this.pans) {
      const from = camera.toWorld(this.canvas, was.x, was.y), to = this.place(e);
      const others = [...this.pointers].filter(([id]) => id !== e.pointerId).map(([, p]) => p);
      if (others.length) {
        const apart = (p) => Math.hypot(p.x - others[0].x, p.y - others[0].y) || 1;
        camera.zoom(apart({ x: e.offsetX, y: e.offsetY }) / apart(was), camera.toWorld(this.canvas, others[0].x, others[0].y));
      } else {
        camera.x += from[0] - to[0], camera.y += from[1] - to[1];
      }
    } else if (this.grab) {
      this.grab.moveTo(...this.place(e));
    }
    this.pointers.set(e.pointerId, { x: e.offsetX, y: e.offsetY });
  }

  up(e) {
    this.pointers.delete(e.pointerId);
    if (this.pointers.size === 0) this.letGo();
  }

  /** Before every step. */
  lead(dt) { this.grab?.lead(dt); }

  letGo() {
    this.grab?.release();
    this.grab = undefined;
  }

  /** The world that the hand held is gone. */
  forget() { this.grab = undefined; }

  kick(x, y) {
    const { world, camera } = this.show;
    const reach = camera.span[0] / 12;
    for (const id of world.inRegion(x - reach, y - reach, x + reach, y + reach)) {
      const body = world.body(id);
      const dx = body.x - x, dy = body.y - y, far = Math.hypot(dx, dy) || 1;
      if (body.type !== 'dynamic' || far > reach) continue;
      const speed = kickSpeed * (reach / far) ** 0.5;
      world.wake(id);
      world.setVelocity(id, body.vx + (speed * dx) / far, body.vy + (speed * dy) / far, body.omega);
    }
  }

  add(tool, x, y) {
    const size = this.show.camera.span[0] / 60;
    const shape = tool === 'disc' ? { disc: { radius: size } } : { box: { size: [2 * size, 2 * size] } };
    this.show.add({ shape, position: [x, y] });
  }
}
