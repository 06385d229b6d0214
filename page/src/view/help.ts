// The keys, and how to read the page.
import { el } from '../shared/dom';
import { kBetweenNotTested, wordsOf } from '../shared/words';

const keysOf = (poses: boolean, { step, collisions, orStart } = wordsOf(poses)): [string, string][] => [
  ['Space', 'play or pause'],
  ['← →', `one ${step} back or forward; with Shift ten`],
  ...(poses ? [] : [[', .', 'a hundredth of a step back or forward'] as [string, string]]),
  ['Home End', 'to the start or the end'],
  ['[ ]', 'slower or faster'],
  ['P N', `previous or next ${step} with ${collisions}${orStart}`],
  ['↑ ↓', 'previous or next contact or pair of the list, and fly there'],
  ['G', 'type a frame'],
  ['R or 0', 'see everything'],
  ['1 2 3 4 5 6', 'from the front, the right, the top, the back, the left, below'],
  ['Z', 'turns the upright axis: y or z'],
  ['Esc', 'leaves the brush, else the chosen contact, pair or triangle'],
  ['W A S D with Shift', 'orbit'],
  ['+ −', 'zoom'],
  ['V', 'next color of the surface'],
  ...(poses ? [] : [['F', 'before or after the repair'] as [string, string]]),
  poses ? ['C K B E X', 'what is inside, key points, boxes, edges, see through'] : ['C M T K B E X', 'what is inside now, what meets in the step, contact points, key points, boxes, edges, see through'],
  ['D', 'light or dark'],
  ['L', 'legend'],
  ['?', 'this help'],
];

const kMotionHelp = [
  'Between two frames every vertex moves along a straight line; this motion is checked and shown. A time of impact is a share of the step: 0 at its start, 1 at its end.',
  'Red is what goes through something, or is inside it, at the time that is shown: it is known exactly for every frame, and between two frames that of the nearer one is shown. Pink is what meets during the step. A step is green if nothing is inside at its begin and nothing meets in it.',
];
const kPosesHelp = [`${kBetweenNotTested} A frame is green if no two triangles cross in it; this is decided exactly.`];

export function helpDialog(poses: boolean): HTMLDialogElement {
  const table = el('table', {});
  for (const [keys, text] of keysOf(poses)) {
    const cell = el('td', {});
    keys.split(' ').forEach((key, k) => {
      if (k > 0) cell.append(' ');
      cell.append(/^(or|with)$/.test(key) ? key : el('kbd', {}, key));
    });
    table.append(el('tr', {}, cell, el('td', {}, text)));
  }
  const dialog = el('dialog', { className: 'help', 'aria-label': 'Help' });
  dialog.append(
    el('form', { method: 'dialog' }, el('h2', {}, 'Keys and mouse'), el('button', { className: 'small' }, 'Close')),
    el('p', {}, 'Drag to orbit, right-drag or two fingers to pan, wheel or pinch to zoom. A click on the surface shows what is known about the triangle; a double click orbits around it. Over the timeline the wheel zooms, with Shift it moves; dragging along the frame numbers marks a range to repeat, a click there ends it.'),
    table,
    ...(poses ? kPosesHelp : kMotionHelp).map((text) => el('p', {}, text)),
  );
  dialog.addEventListener('click', (event) => {
    if (event.target === dialog) dialog.close();
  });
  return dialog;
}
