#include "oracle/polynomial.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace foldproof::oracle {
namespace {

int sign(const Int& value) { return value.sign(); }

// lc(b)^(2k) a = q b + r: an even power of the leading coefficient is positive, so the remainder keeps the
// sign that Sturm's theorem needs.
Polynomial remainder(const Polynomial& a, const Polynomial& b) {
  std::vector<Int> r;
  for (int i = 0; i <= a.degree(); ++i) r.push_back(a[i]);
  const Int square = b.leading() * b.leading();
  for (int top = a.degree(); top >= b.degree(); --top) {
    const Int factor = r[top] * b.leading();
    for (int i = 0; i < top; ++i) r[i] *= square;
    for (int i = 0; i < b.degree(); ++i) r[top - b.degree() + i] -= factor * b[i];
    r.pop_back();
  }
  return Polynomial(std::move(r));
}

// Divides by the greatest common divisor of the coefficients, a positive number.
Polynomial primitive(const Polynomial& p) {
  Int content = 0;
  for (int i = 0; i <= p.degree(); ++i) content = boost::multiprecision::gcd(content, p[i]);
  if (content <= 1) return p;
  std::vector<Int> c;
  for (int i = 0; i <= p.degree(); ++i) c.push_back(p[i] / content);
  return Polynomial(std::move(c));
}

// a / b for a multiple a of b, up to a positive factor.
Polynomial quotient(const Polynomial& a, const Polynomial& b) {
  std::vector<Int> r, q(a.degree() - b.degree() + 1);
  for (int i = 0; i <= a.degree(); ++i) r.push_back(a[i]);
  const Int square = b.leading() * b.leading();
  for (int top = a.degree(); top >= b.degree(); --top) {
    const Int factor = r[top] * b.leading();
    for (Int& earlier : q) earlier *= square;
    q[top - b.degree()] = factor;
    for (int i = 0; i < top; ++i) r[i] *= square;
    for (int i = 0; i < b.degree(); ++i) r[top - b.degree() + i] -= factor * b[i];
  }
  return primitive(Polynomial(std::move(q)));
}

}  // namespace

Dyadic Dyadic::from_double(double value) {
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  Dyadic result;
  result.numerator = static_cast<std::int64_t>(std::ldexp(fraction, 53));
  exponent -= 53;
  if (result.numerator == 0) return result;
  if (exponent >= 0) {
    result.numerator <<= exponent;
    return result;
  }
  const unsigned even = std::min<unsigned>(lsb(abs(result.numerator)), -exponent);
  result.numerator >>= even;
  result.exponent = static_cast<unsigned>(-exponent) - even;
  return result;
}

Dyadic midpoint(const Dyadic& a, const Dyadic& b) {
  const unsigned exponent = std::max(a.exponent, b.exponent);
  Dyadic m;
  m.numerator = (a.numerator << (exponent - a.exponent)) + (b.numerator << (exponent - b.exponent));
  m.exponent = exponent + 1;
  return m;
}

int compare(const Dyadic& a, const Dyadic& b) {
  const unsigned exponent = std::max(a.exponent, b.exponent);
  return (a.numerator << (exponent - a.exponent)).compare(b.numerator << (exponent - b.exponent));
}

Polynomial::Polynomial(std::vector<Int> coefficients) : coefficients_(std::move(coefficients)) {
  while (!coefficients_.empty() && coefficients_.back().is_zero()) coefficients_.pop_back();
}

int Polynomial::sign_at(const Dyadic& t) const {
  if (is_zero()) return 0;
  Int value = leading();
  for (int i = degree() - 1; i >= 0; --i) {
    value = value * t.numerator + (coefficients_[i] << (t.exponent * (degree() - i)));
  }
  return sign(value);
}

Polynomial Polynomial::derivative() const {
  std::vector<Int> c;
  for (int i = 1; i <= degree(); ++i) c.push_back(coefficients_[i] * i);
  return Polynomial(std::move(c));
}

Polynomial operator+(const Polynomial& a, const Polynomial& b) {
  std::vector<Int> c = a.coefficients_;
  c.resize(std::max(c.size(), b.coefficients_.size()));
  for (std::size_t i = 0; i < b.coefficients_.size(); ++i) c[i] += b.coefficients_[i];
  return Polynomial(std::move(c));
}

Polynomial operator-(const Polynomial& a, const Polynomial& b) {
  std::vector<Int> c = a.coefficients_;
  c.resize(std::max(c.size(), b.coefficients_.size()));
  for (std::size_t i = 0; i < b.coefficients_.size(); ++i) c[i] -= b.coefficients_[i];
  return Polynomial(std::move(c));
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  if (a.is_zero() || b.is_zero()) return {};
  std::vector<Int> c(a.coefficients_.size() + b.coefficients_.size() - 1);
  for (std::size_t i = 0; i < a.coefficients_.size(); ++i) {
    for (std::size_t j = 0; j < b.coefficients_.size(); ++j)
      c[i + j] += a.coefficients_[i] * b.coefficients_[j];
  }
  return Polynomial(std::move(c));
}

Polynomial gcd(const Polynomial& a, const Polynomial& b) {
  Polynomial p = a, q = b;
  if (p.degree() < q.degree()) std::swap(p, q);
  while (!q.is_zero()) {
    Polynomial r = primitive(remainder(p, q));
    p = std::move(q);
    q = std::move(r);
  }
  return p;
}

Sturm::Sturm(const Polynomial& p) {
  const Polynomial common = p.degree() >= 1 ? gcd(p, p.derivative()) : Polynomial({Int(1)});
  chain_.push_back(common.degree() >= 1 ? quotient(p, common) : p);
  chain_.push_back(chain_[0].derivative());
  while (!chain_.back().is_zero()) {
    const Polynomial r = primitive(remainder(chain_[chain_.size() - 2], chain_.back()));
    chain_.push_back(Polynomial() - r);
  }
  chain_.pop_back();
}

int Sturm::variations(const Dyadic& t) const {
  int count = 0, last = 0;
  for (const Polynomial& p : chain_) {
    const int s = p.sign_at(t);
    if (s == 0) continue;
    count += last == -s;
    last = s;
  }
  return count;
}

void Root::halve() {
  const Dyadic middle = midpoint(lo_, hi_);
  if (polynomial_->square_free().sign_at(middle) == 0) {
    lo_ = hi_ = middle;
  } else if (polynomial_->roots_in(lo_, middle) == 1) {
    hi_ = middle;
  } else {
    lo_ = middle;
  }
}

int Root::sign_of(const Polynomial& q) {
  if (q.degree() <= 0) return q.is_zero() ? 0 : sign(q.leading());
  if (is_dyadic()) return q.sign_at(hi_);
  const Polynomial common = gcd(polynomial_->square_free(), q);
  if (common.degree() >= 1 && Sturm(common).roots_in(lo_, hi_) > 0) {
    // A root of the common factor in (lo, hi] is a root of our polynomial there. hi itself is not one, so it
    // is us.
    return 0;
  }
  const Sturm roots_of_q(q);
  while (!is_dyadic() && (q.sign_at(lo_) == 0 || roots_of_q.roots_in(lo_, hi_) > 0)) halve();
  return q.sign_at(hi_);
}

namespace {

// Roots in (lo, hi].
void append_roots(const Sturm& polynomial, const Dyadic& lo, const Dyadic& hi, std::vector<Root>& roots) {
  const int inside = polynomial.roots_in(lo, hi);
  if (inside == 0) return;
  if (inside == 1) {
    const bool at_end = polynomial.square_free().sign_at(hi) == 0;
    roots.emplace_back(&polynomial, at_end ? hi : lo, hi);
    return;
  }
  const Dyadic middle = midpoint(lo, hi);
  append_roots(polynomial, lo, middle, roots);
  append_roots(polynomial, middle, hi, roots);
}

}  // namespace

std::vector<Root> roots_within(const Sturm& polynomial, const Dyadic& lo, const Dyadic& hi) {
  std::vector<Root> roots;
  if (polynomial.square_free().sign_at(lo) == 0) roots.emplace_back(&polynomial, lo, lo);
  append_roots(polynomial, lo, hi, roots);
  return roots;
}

}  // namespace foldproof::oracle
