// The power law through points: y ≈ factor × x^exponent, by least squares of the logarithms.

const kLeastSpan = Math.log(1.25);

/** Of the points [x, y] with both above 0; null where no two differ in x by a quarter. */
export function fitPower(points) {
  const logs = points.filter(([x, y]) => x > 0 && y > 0).map(([x, y]) => [Math.log(x), Math.log(y)]);
  const abscissas = logs.map(([x]) => x);
  if (logs.length < 2 || Math.max(...abscissas) - Math.min(...abscissas) < kLeastSpan) return null;
  const mean = (axis) => logs.reduce((sum, point) => sum + point[axis], 0) / logs.length;
  const [meanX, meanY] = [mean(0), mean(1)];
  let covariance = 0;
  let variance = 0;
  for (const [x, y] of logs) {
    covariance += (x - meanX) * (y - meanY);
    variance += (x - meanX) ** 2;
  }
  const exponent = covariance / variance;
  return { exponent, at: (x) => Math.exp(meanY + exponent * (Math.log(x) - meanX)) };
}
