// A hand that pulls a body: an anchor that nothing collides with, and two springs from it to the point that was taken.
// The springs end far from the anchor at right angles and are as long as that is far. Together they are a soft pin that
// is damped whichever way the body moves; a single spring of length 0 would let it circle.

const frequency = 25; // rad/s
const mostPull = 1000; // m/s^2
const springLength = 100; // times the stretch: nearly parallel wherever the body is
const rate = 12; // 1/s, at which the anchor follows the hand

export class Grab {
  static begin(world, x, y, reach, massOf) {
    const hit = world.closest(x, y, reach, { dynamic: true });
    if (!hit) return undefined;
    const grab = new Grab();
    grab.world = world;
    grab.body = hit.body;
    grab.target = [x, y];
    const body = world.body(hit.body);
    const [px, py] = hit.point;
    const c = Math.cos(body.angle), s = Math.sin(body.angle), dx = px - body.x, dy = py - body.y;
    grab.arm = [c * dx + s * dy, c * dy - s * dx];
    grab.stretch = Math.max(mostPull / frequency ** 2, body.radius);
    grab.place = [px, py];
    grab.anchor = world.add({
      type: 'kinematic', position: hit.point, category: 0, mask: 0,
      shape: { disc: { radius: body.radius } }, // of a size that the world has: lists follow the smallest
    });
    const mass = typeof massOf === 'function' ? massOf(hit.body.index) : massOf ?? Math.PI * body.radius ** 2;
    const far = springLength * grab.stretch;
    for (const anchorA of [[far, 0], [0, far]]) {
      world.addJoint('spring', grab.anchor, grab.body, {
        anchorA, anchorB: grab.arm, length: far, collide: true,
        stiffness: mass * frequency ** 2, damping: 2 * mass * frequency,
      });
    }
    return grab;
  }

  /** Where the hand is now. */
  moveTo(x, y) { this.target = [x, y]; }

  /** Before every step: leads the anchor to the hand, but no further from the body than it may pull. */
  lead(dt = 1 / 60) {
    const b = this.world.body(this.body);
    const c = Math.cos(b.angle), s = Math.sin(b.angle);
    const held = [b.x + c * this.arm[0] - s * this.arm[1], b.y + s * this.arm[0] + c * this.arm[1]];
    const share = 1 - Math.exp(-rate * dt);
    const next = [0, 1].map((k) => this.place[k] + share * (this.target[k] - this.place[k]));
    const far = Math.hypot(next[0] - held[0], next[1] - held[1]);
    const [xmin, ymin, xmax, ymax] = this.world.settings.bounds;
    const low = [xmin, ymin], high = [xmax, ymax];
    this.place = next.map((n, k) => {
      const near = far > this.stretch ? held[k] + ((n - held[k]) * this.stretch) / far : n;
      const margin = 1e-6 * (high[k] - low[k]);
      return Math.min(Math.max(near, low[k] + margin), high[k] - margin);
    });
    this.world.wake(this.body);
    this.world.setTransform(this.anchor, ...this.place);
  }

  release() {
    this.world.remove(this.anchor); // and the springs
  }
}
