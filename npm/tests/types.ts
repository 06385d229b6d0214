// What the package's types allow, and what not.
import { FoldproofError, StepChecker, check, type Contact } from 'foldproof';

const faces = [[0, 1, 2]];
const frames = [new Float32Array(9), new Float64Array(9)];
const found = await check({ faces, frames }, { thickness: 0.1, onProgress: (share) => share.toFixed() });
const pairs: number = found.steps[0]!.vertexFaceCount;
const worst: Contact | undefined = found.contacts[0];
const poses = await check([{ faces: new Uint16Array(3), frames, parts: ['a'] }], { static: true });
const crossing: Uint32Array = poses.steps[0]!.crossings.triangleA;
// @ts-expect-error: a pose has no pairs of features
poses.steps[0]!.vertexFace;
// @ts-expect-error: no such setting
await check({ faces, frames }, { thicknes: 0.1 });
const checker = await StepChecker.create({ faces, positions: frames[0]! });
const marks: Uint8Array | undefined = checker.check(frames[0]!, frames[1]!).collidingFaces[0];
export const all = [pairs, worst, crossing, marks, FoldproofError];
