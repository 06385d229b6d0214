/// Integer polynomials of one variable, their real roots as algebraic numbers, and exact signs at those
/// roots.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>
#include <vector>

namespace foldproof::oracle {

/// Unbounded integer; the first 1024 bits need no allocation.
using Int = boost::multiprecision::number<
    boost::multiprecision::cpp_int_backend<1024, 0, boost::multiprecision::signed_magnitude,
                                           boost::multiprecision::unchecked>,
    boost::multiprecision::et_off>;

/// numerator / 2^exponent, exponent >= 0.
struct Dyadic {
  Int numerator = 0;
  unsigned exponent = 0;

  /// Exact for every finite double.
  static Dyadic from_double(double value);
};
Dyadic midpoint(const Dyadic& a, const Dyadic& b);
/// Sign of a - b.
int compare(const Dyadic& a, const Dyadic& b);

/// Sum of coefficient[i] t^i. No trailing zero coefficients: the zero polynomial is empty.
class Polynomial {
 public:
  Polynomial() = default;
  explicit Polynomial(std::vector<Int> coefficients);

  bool is_zero() const { return coefficients_.empty(); }
  /// -1 for the zero polynomial.
  int degree() const { return static_cast<int>(coefficients_.size()) - 1; }
  const Int& operator[](std::size_t i) const { return coefficients_[i]; }
  const Int& leading() const { return coefficients_.back(); }

  int sign_at(const Dyadic& t) const;
  Polynomial derivative() const;

  friend Polynomial operator+(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator-(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b);

 private:
  std::vector<Int> coefficients_;
};

/// Greatest common divisor up to a non-zero constant factor. Constant when the arguments have no common root.
Polynomial gcd(const Polynomial& a, const Polynomial& b);

/// Counts the distinct real roots of a polynomial by Sturm's theorem.
class Sturm {
 public:
  /// Precondition: p is not zero. Repeated factors are removed first.
  explicit Sturm(const Polynomial& p);

  const Polynomial& square_free() const { return chain_.front(); }
  /// Distinct roots in the half-open interval (lo, hi].
  int roots_in(const Dyadic& lo, const Dyadic& hi) const { return variations(lo) - variations(hi); }

 private:
  int variations(const Dyadic& t) const;
  std::vector<Polynomial> chain_;
};

/// One real root: either the dyadic number hi (when lo == hi), or the only root of its polynomial in the open
/// interval (lo, hi).
class Root {
 public:
  Root(const Sturm* polynomial, Dyadic lo, Dyadic hi) : polynomial_(polynomial), lo_(lo), hi_(hi) {}

  bool is_dyadic() const { return compare(lo_, hi_) == 0; }
  bool is_at(const Dyadic& t) const { return is_dyadic() && compare(t, hi_) == 0; }
  /// Exact sign of q at this root. Tightens the interval as far as needed.
  int sign_of(const Polynomial& q);

 private:
  void halve();
  const Sturm* polynomial_;  // Not owned; outlives the root.
  Dyadic lo_, hi_;
};

/// Every distinct root in the closed interval [lo, hi], in ascending order.
std::vector<Root> roots_within(const Sturm& polynomial, const Dyadic& lo, const Dyadic& hi);

}  // namespace foldproof::oracle
