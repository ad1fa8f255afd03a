#include "drivers/sim/psf_family.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/base/check.h"

namespace reseau::sim {
namespace {

constexpr double kWidestPx = 256;  // of the tail's Gaussians; the rest of the tail joins the last
constexpr double kLeftOut = 1e-5;  // of a spread function, by truncating the sum
constexpr double kCutOff = 5e-6;   // light beyond the reach of a component
constexpr int kMaxRank = 32;
constexpr double kEdgeFrequency = 0.1;  // cycles/px
constexpr double kFocusStep = 0.01;     // waves at the pupil's edge between tables
constexpr int kMaxFocus = 161, kFocusForBasis = 24;

double sinc(double x) { return std::abs(x) < 1e-9 ? 1.0 : std::sin(x) / x; }

double transfer_of(const std::vector<WideGaussian>& wide, double f_x, double f_y) {
  double sum = 0;
  for (const WideGaussian& g : wide) {
    const double a = g.sigma_x_px * f_x, b = g.sigma_y_px * f_y;
    sum += g.amplitude * std::exp(-2 * std::numbers::pi * std::numbers::pi * (a * a + b * b));
  }
  return sum;
}

// A lens in focus and with equal axes is a function of |f|: one table instead of an integral per
// frequency.
class RadialLens {
 public:
  explicit RadialLens(double waves) : values_(kSteps + 4) {
    for (int i = 0; i < kSteps + 4; ++i) {
      // One node before 0 and two past 1 for the interpolation.
      const double s = static_cast<double>(i - 1) / kSteps;
      values_[static_cast<std::size_t>(i)] =
          s < 0 ? 2 * lens_transfer(0, 0, waves, waves) - lens_transfer(-s, 0, waves, waves)
                : lens_transfer(s, 0, waves, waves);
    }
  }
  [[nodiscard]] double operator()(double s) const {
    if (s >= 1) return 0;
    const double at = s * kSteps;
    const auto i = static_cast<std::size_t>(at);
    const double t = at - std::floor(at);
    const double a = values_[i], b = values_[i + 1], c = values_[i + 2], d = values_[i + 3];
    return b + t * (c - b) +
           t * (t - 1) / 6 * ((t + 1) * (d - 2 * c + b) - (t - 2) * (c - 2 * b + a));
  }

 private:
  static constexpr int kSteps = 1024;
  std::vector<double> values_;
};

// What a family is made of: frequencies and the spectrum of what the cells have to do.
class Spectrum {
 public:
  Spectrum(const OpticalTransfer& transfer, const CellGrid& grid, double largest_um)
      : transfer_(transfer), grid_(grid), wide_(wide_gaussians(transfer)) {
    double highest = grid.per_px / 2.0;
    const bool narrow_halo = transfer.halo_fraction() > 0 && transfer.halo_px() < kWidePx;
    double smallest = transfer.core_px();
    if (narrow_halo) smallest = std::min(smallest, transfer.halo_px());
    if (smallest > 0) highest = std::min(highest, 1.0 / smallest);  // exp(-2 pi^2) = 3e-9
    if (transfer.has_lens() && !narrow_halo) highest = std::min(highest, transfer.cutoff());
    double radius =
        3 + 5 * transfer.core_px() + transfer.aperture_x_px() / 2 + transfer.aperture_y_px() / 2;
    if (narrow_halo) radius += 5 * transfer.halo_px();
    // Half the blur disc: 8 |W| wavelengths times f-number.
    if (transfer.has_lens()) {
      radius += 3.5 * kWidePx + 3 / transfer.cutoff() +
                4 * std::abs(transfer.waves(largest_um)) / transfer.cutoff();
    }
    period_px_ = std::max(32.0, std::ceil(2.5 * radius));
    n_ = static_cast<int>(std::ceil(highest * period_px_)) + 1;
    // The highest frequency of the grid belongs to both ends of its band.
    n_ = std::min(n_, static_cast<int>(std::ceil(grid.per_px * period_px_ / 2)));
  }
  [[nodiscard]] int n() const { return n_; }
  [[nodiscard]] double period_px() const { return period_px_; }
  [[nodiscard]] double at_zero() const { return 1 - transfer_of(wide_, 0, 0); }
  [[nodiscard]] static double weight(int a) { return a == 0 ? 1.0 : std::numbers::sqrt2; }
  // How much an error at this frequency counts: as films have detail there, whose amplitude falls
  // with frequency along each axis as that of edges and corners does.
  [[nodiscard]] double importance(int a) const {
    const double f = a / period_px_ / kEdgeFrequency;
    return 1 / std::sqrt(1 + f * f);
  }

  // [f_x][f_y], each axis weighted so that squares add up to those of the spread function, as
  // important as the frequencies are.
  [[nodiscard]] Eigen::MatrixXd matrix(double defocus_um) const {
    const bool radial = transfer_.has_lens() && transfer_.astigmatism_um() == 0;
    const RadialLens lens(radial ? transfer_.waves(defocus_um) : 0.0);
    Eigen::MatrixXd m(n_, n_);
    for (int a = 0; a < n_; ++a) {
      for (int b = 0; b < n_; ++b) {
        const double f_x = a / period_px_, f_y = b / period_px_;
        const double t = radial ? radial_transfer(lens, f_x, f_y) : transfer_(f_x, f_y, defocus_um);
        m(a, b) = weight(a) * weight(b) * importance(a) * importance(b) *
                  (t - transfer_of(wide_, f_x, f_y)) / (grid_.transfer(f_x) * grid_.transfer(f_y));
      }
    }
    return m;
  }

  // Cosines of all frequencies at so many cells from the centre, weighted to undo matrix().
  [[nodiscard]] Eigen::MatrixXd cosines(int n_places, double steps_per_cell) const {
    Eigen::MatrixXd c(n_places, n_);
    for (int i = 0; i < n_places; ++i) {
      const double x = i / (steps_per_cell * grid_.per_px);
      for (int a = 0; a < n_; ++a) {
        c(i, a) = weight(a) / importance(a) * std::cos(2 * std::numbers::pi * a / period_px_ * x) /
                  (period_px_ * grid_.per_px);
      }
    }
    return c;
  }

 private:
  [[nodiscard]] double radial_transfer(const RadialLens& lens, double f_x, double f_y) const {
    const double f = std::hypot(f_x, f_y), core = transfer_.core_px() * f;
    const double sharp = lens(f / transfer_.cutoff()) *
                         std::exp(-2 * std::numbers::pi * std::numbers::pi * core * core);
    const double h = transfer_.halo_fraction();
    const double mixed = h == 0 ? sharp : (1 - h) * sharp + h * transfer_.halo(f * f);
    return mixed * transfer_.aperture(f_x, f_y);
  }

  OpticalTransfer transfer_;
  CellGrid grid_;
  std::vector<WideGaussian> wide_;
  double period_px_;
  int n_;
};

// Smallest number of cells beyond which both profiles hold less than kCutOff of the light.
int find_reach(const Eigen::VectorXd& u, const Eigen::VectorXd& v) {
  const double u_sum = 2 * u.cwiseAbs().sum(), v_sum = 2 * v.cwiseAbs().sum();
  double u_tail = 0, v_tail = 0;
  int reach = static_cast<int>(u.size()) - 1;
  for (; reach > 1; --reach) {
    u_tail += 2 * std::abs(u[reach]);
    v_tail += 2 * std::abs(v[reach]);
    if (u_tail * v_sum > kCutOff || v_tail * u_sum > kCutOff) break;
  }
  return std::min(reach + 1, static_cast<int>(u.size()) - 1);
}

// 1 up to nine tenths of the reach, then down to 0.
double taper(double cells, int reach) {
  const double t = std::abs(cells) / reach;
  constexpr double kBegin = 0.9;
  if (t <= kBegin) return 1;
  if (t >= 1) return 0;
  const double c = std::cos(std::numbers::pi / 2 * (t - kBegin) / (1 - kBegin));
  return c * c;
}

}  // namespace

std::vector<WideGaussian> wide_gaussians(const OpticalTransfer& transfer) {
  std::vector<WideGaussian> wide;
  const double a_x = transfer.aperture_x_px(), a_y = transfer.aperture_y_px();
  if (transfer.has_lens()) {
    // The transfer begins as 1 - 4/pi |f| / cutoff; a mixture of Gaussians with density
    // mass(sigma) = c / sigma^2 has that cusp. Here in steps of sqrt 2.
    const double c = 2 / (std::numbers::pi * std::numbers::pi * transfer.cutoff()) *
                     std::sqrt(2 / std::numbers::pi);
    const double step = std::log(2.0) / 2, ratio = 1 / std::numbers::sqrt2;
    for (double sigma = kWidePx; sigma <= kWidestPx * 1.001; sigma *= std::numbers::sqrt2) {
      double mass = (1 - transfer.halo_fraction()) * c / sigma * step;
      if (sigma * std::numbers::sqrt2 > kWidestPx * 1.001) mass /= 1 - ratio;
      wide.push_back({mass, sigma, sigma});
    }
  }
  if (transfer.halo_fraction() > 0 && transfer.halo_px() >= kWidePx) {
    const double s = transfer.halo_px() * transfer.halo_px();
    wide.push_back(
        {transfer.halo_fraction(), std::sqrt(s + a_x * a_x / 12), std::sqrt(s + a_y * a_y / 12)});
  }
  return wide;
}

double CellGrid::transfer(double f) const {
  double t = sinc(std::numbers::pi * f / fine_per_px);
  if (tents) t *= t;
  for (int cells = fine_per_px; cells > per_px; cells /= 2) {
    const double c = std::cos(std::numbers::pi * f / cells);
    t *= c * c * c * c * c;
  }
  return t;
}

CellGrid choose_grid(int fine_per_px, const std::vector<OpticalTransfer>& transfers,
                     int fewest_per_px) {
  constexpr double kNegligible = 2e-3;  // of transfer, where a film holds a few per cent of detail
  CellGrid grid{fine_per_px, fine_per_px};
  while (grid.per_px % 2 == 0 && grid.per_px >= std::max(6, 2 * fewest_per_px)) {
    for (const OpticalTransfer& transfer : transfers) {
      for (double f = grid.per_px / 4.0; f < grid.per_px / 2.0; f += 0.05) {
        if (std::abs(transfer(f, 0, 0)) > kNegligible ||
            std::abs(transfer(0, f, 0)) > kNegligible) {
          return grid;
        }
      }
    }
    grid.per_px /= 2;
  }
  return grid;
}

PsfFamily::PsfFamily(const OpticalTransfer& transfer, const CellGrid& grid, double min_um,
                     double max_um)
    : min_um_(min_um) {
  CHECK(max_um >= min_um);
  const double range = transfer.has_lens() ? std::abs(transfer.waves(max_um - min_um)) : 0.0;
  if (range > 1e-4) {
    n_focus_ = std::clamp(static_cast<int>(std::ceil(range / kFocusStep)) + 1, 2, kMaxFocus);
    step_um_ = (max_um - min_um) / (n_focus_ - 1);
  }
  const Spectrum spectrum(
      transfer, grid,
      std::max(std::abs(min_um), std::abs(max_um)) + std::abs(transfer.astigmatism_um()));
  const int n = spectrum.n();

  // The profiles along y that together explain most of all spread functions: eigenvectors of the
  // sum of their squares.
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(n, n);
  const int every = (n_focus_ + kFocusForBasis - 1) / kFocusForBasis;
  for (int k = 0; k < n_focus_; k += every) {
    const Eigen::MatrixXd m = spectrum.matrix(min_um + k * step_um_);
    gram.noalias() += m.transpose() * m;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  const int most = std::min(kMaxRank, n);
  const Eigen::MatrixXd basis = solver.eigenvectors().rightCols(most).rowwise().reverse();
  std::vector<Eigen::MatrixXd> projected;  // [focus]: spectrum along x of each component
  int rank = 1;
  for (int k = 0; k < n_focus_; ++k) {
    const Eigen::MatrixXd m = spectrum.matrix(min_um + k * step_um_);
    projected.push_back(m * basis);
    const double all = m.squaredNorm();
    // Squares would lose half the digits of what is left; the rest itself does not.
    Eigen::MatrixXd rest = m;
    for (int r = 0; r < most; ++r) {
      rest.noalias() -= projected.back().col(r) * basis.col(r).transpose();
      const double left = std::sqrt(rest.squaredNorm() / all);
      if (left > kLeftOut && r + 2 > rank) rank = std::min(r + 2, most);
      if (r + 1 >= rank && left <= kLeftOut) {
        left_out_ = std::max(left_out_, left);
        break;
      }
      if (r + 1 == most) left_out_ = std::max(left_out_, left);
    }
  }

  // How far each component reaches.
  const int farthest = static_cast<int>(spectrum.period_px() / 2 * grid.per_px) - 1;
  const Eigen::MatrixXd coarse = spectrum.cosines(farthest + 1, 1);
  const Eigen::MatrixXd along_y = coarse * basis.leftCols(rank);
  std::vector<int> reach(static_cast<std::size_t>(rank), 1);
  for (const Eigen::MatrixXd& p : projected) {
    const Eigen::MatrixXd along_x = coarse * p.leftCols(rank);
    for (int r = 0; r < rank; ++r) {
      int& longest = reach[static_cast<std::size_t>(r)];
      longest = std::max(longest, find_reach(along_x.col(r), along_y.col(r)));
    }
  }
  std::size_t offset = 0;
  for (int r = 0; r < rank; ++r) {
    Component c;
    c.reach_cells = reach[static_cast<std::size_t>(r)];
    reach_cells_ = std::max(reach_cells_, c.reach_cells);
    c.taps = (2 * c.reach_cells + 2 + 3) / 4 * 4;
    c.offset = offset;
    offset += static_cast<std::size_t>(c.taps);
    components_.push_back(std::move(c));
  }
  table_size_ = offset;

  static_assert(kPhases == kProfileSteps);
  const int n_fine = (reach_cells_ + 2) * kPhases + 2;
  const Eigen::MatrixXd fine = spectrum.cosines(n_fine, kPhases);
  const Eigen::MatrixXd fine_y = fine * basis.leftCols(rank);
  // Light of a component, mean over all places of the centre within a cell.
  const auto tapered_sum = [&](const Eigen::MatrixXd& profile, int r, int cells) {
    double sum = 0;
    for (int i = 0; i < n_fine; ++i) {
      sum += (i == 0 ? 1 : 2) * profile(i, r) * taper(static_cast<double>(i) / kPhases, cells);
    }
    return sum / kPhases;
  };
  for (int r = 0; r < rank; ++r) {
    Component& c = components_[static_cast<std::size_t>(r)];
    for (int i = 0; i < n_fine; ++i) {
      c.profile.push_back(fine_y(i, r) * taper(static_cast<double>(i) / kPhases, c.reach_cells));
    }
  }
  tables_.assign(static_cast<std::size_t>(n_focus_) * (kPhases + 1) * table_size_, 0.0F);
  for (int k = 0; k < n_focus_; ++k) {
    const Eigen::MatrixXd fine_x = fine * projected[static_cast<std::size_t>(k)].leftCols(rank);
    double light = 0;
    for (int r = 0; r < rank; ++r) {
      const int cells = components_[static_cast<std::size_t>(r)].reach_cells;
      light += tapered_sum(fine_x, r, cells) * tapered_sum(fine_y, r, cells);
    }
    const double gain = spectrum.at_zero() / light;
    for (int phase = 0; phase <= kPhases; ++phase) {
      float* to = tables_.data() +
                  (static_cast<std::size_t>(k) * (kPhases + 1) + static_cast<std::size_t>(phase)) *
                      table_size_;
      for (int r = 0; r < rank; ++r) {
        const Component& c = components_[static_cast<std::size_t>(r)];
        for (int t = 0; t < 2 * c.reach_cells + 2; ++t) {
          const int steps = std::abs((t - c.reach_cells) * kPhases - phase);
          const double cells = static_cast<double>(steps) / kPhases;
          to[c.offset + static_cast<std::size_t>(t)] = static_cast<float>(
              gain * fine_x(std::min(steps, n_fine - 1), r) * taper(cells, c.reach_cells));
        }
      }
    }
  }
}

double PsfFamily::along_y(int r, double cells) const {
  const std::vector<double>& p = components_[static_cast<std::size_t>(r)].profile;
  const double at = std::abs(cells) * kProfileSteps;
  const auto i = static_cast<std::size_t>(at);
  if (i + 2 >= p.size()) return 0;
  const double t = at - std::floor(at);
  const double a = i == 0 ? p[1] : p[i - 1], b = p[i], c = p[i + 1], d = p[i + 2];
  return b + t * (c - b) +
         t * (t - 1) / 6 * ((t + 1) * (d - 2 * c + b) - (t - 2) * (c - 2 * b + a));
}

double PsfFamily::focus_index(double defocus_um) const {
  if (n_focus_ == 1) return 0;
  return std::clamp((defocus_um - min_um_) / step_um_, 0.0, n_focus_ - 1.0);
}

}  // namespace reseau::sim
