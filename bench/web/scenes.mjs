// The scenes of the comparison as plain numbers, for every engine the same: bodies without bounce, friction 0.5, no sleep.

/** A block of discs with a little play, which falls a little and settles between two walls. */
export function discs(count) {
  const columns = Math.ceil(Math.sqrt(count));
  const bodies = [];
  for (let k = 0; k < count; ++k) {
    const column = k % columns, row = Math.floor(k / columns);
    bodies.push({ x: 1.05 * column + 0.025 * (row % 3), y: 0.5 + 1.05 * row });
  }
  const width = 1.05 * columns;
  return { name: `${count} discs`, disc: true, bodies, floor: [-1, width], height: 2 * width };
}

/** Boxes of a metre in rows, each on two below. */
export function pyramid(base) {
  const bodies = [];
  for (let row = 0; row < base; ++row) {
    for (let k = 0; k < base - row; ++k) bodies.push({ x: k - 0.5 * (base - row - 1), y: 0.5 + row });
  }
  return { name: `pyramid of ${bodies.length} boxes`, disc: false, bodies, floor: [-base, base], height: 2 * base };
}

export const gravity = -9.81, friction = 0.5, dt = 1 / 60;
