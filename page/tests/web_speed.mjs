// How long steps take in WebAssembly and in the program, each with one thread, three times in turn:
// npm run measure:web -- FILE[,FILE...]..., with files of one motion joined by commas.
import { engineOf } from './engine.mjs';
import { run } from './program.mjs';

/** Milliseconds of all steps. */
const sum = (times) => times.reduce((all, time) => all + time, 0);

async function inWebAssembly(files) {
  const get = await engineOf(files);
  const { steps } = JSON.parse(String(await get('steps')));
  return { ms: sum(steps.map((step) => step.ms.total)), steps: steps.length, pairs: sum(steps.map((step) => step.vertex_face + step.edge_edge)) };
}

function inProgram(files) {
  const { steps } = JSON.parse(run('check', ...files, '--threads', '1', '--json', '-', '--quiet'));
  return sum(steps.map((step) => step.milliseconds.total));
}

console.log('| motion | steps | colliding pairs | WebAssembly in Node | program | ratio |\n|---|---|---|---|---|---|');
for (const motion of process.argv.slice(2)) {
  const files = motion.split(',');
  let web = Infinity;
  let program = Infinity;
  let found;
  for (let round = 0; round < 3; ++round) {
    found = await inWebAssembly(files);
    web = Math.min(web, found.ms);
    program = Math.min(program, inProgram(files));
  }
  console.log(`| ${files[0]} | ${found.steps} | ${found.pairs.toLocaleString('en')} | ${(web / 1000).toFixed(2)} s | ${(program / 1000).toFixed(2)} s | ${(web / program).toFixed(1)} |`);
}
