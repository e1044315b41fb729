const table = document.getElementById('table');
const heads = table ? [...table.tHead.rows[0].cells] : [];
heads.forEach((head, column) => head.firstElementChild.onclick = () => {
  const sign = head.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
  heads.forEach(other => other.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort', sign > 0 ? 'ascending' : 'descending');
  const key = row => row.cells[column].dataset.key ?? row.cells[column].textContent;
  const byNumber = head.classList.contains('n');
  const body = table.tBodies[0];
  const order = (a, b) => {
    const [x, y] = [key(a), key(b)];
    if (x === '' || y === '') return (x === '') - (y === ''); // rows without a figure come last
    return sign * (byNumber ? x - y || 0 : x.localeCompare(y));
  };
  body.append(...[...body.rows].sort(order));
});
heads.forEach(head => head.firstElementChild.onkeydown = event => {
  if (event.key !== 'Enter' && event.key !== ' ') return;
  event.preventDefault();
  head.firstElementChild.click();
});
