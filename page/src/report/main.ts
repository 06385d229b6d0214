import './report.css';
document.body.textContent = 'Foldproof';
