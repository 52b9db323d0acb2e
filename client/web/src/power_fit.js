// The power law through points: y ≈ factor × x^exponent, by least squares of the logarithms.

/** Of the points [x, y] with both above 0; null where fewer than two differ in x. */
export function fitPower(points) {
  const logs = points.filter(([x, y]) => x > 0 && y > 0).map(([x, y]) => [Math.log(x), Math.log(y)]);
  if (logs.length < 2) return null;
  const mean = (axis) => logs.reduce((sum, point) => sum + point[axis], 0) / logs.length;
  const [meanX, meanY] = [mean(0), mean(1)];
  let covariance = 0;
  let variance = 0;
  for (const [x, y] of logs) {
    covariance += (x - meanX) * (y - meanY);
    variance += (x - meanX) ** 2;
  }
  if (variance < 1e-12) return null;
  const exponent = covariance / variance;
  return { exponent, at: (x) => Math.exp(meanY + exponent * (Math.log(x) - meanX)) };
}
