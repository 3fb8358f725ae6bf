// Where the tests find what tools/cross web built.
import { fileURLToPath } from 'node:url';

export const root = fileURLToPath(new URL('../../', import.meta.url));
export const built = `${root}build/web/`;
