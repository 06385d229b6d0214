import './view.css';
document.querySelector('#app')!.textContent = 'Foldproof';
