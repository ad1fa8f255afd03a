#include "core/reconstruct/blur_table.h"

namespace reseau {

BlurTable::Left left_of(const ElementModel::Columns& columns) {
  const Eigen::HouseholderQR<ElementModel::Columns> qr(columns);
  const Eigen::Matrix<double, kTileAmplitudes, kTileAmplitudes> q = qr.householderQ();
  return q.rightCols<BlurTable::kLeft>();
}

BlurTable::BlurTable(const ElementModel& model, const BlurShape& shape) {
  const int n = 1 + static_cast<int>(index_of(kMostSigmaPx));
  left_.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) left_.push_back(left_of(model.columns(sigma_px(i), shape)));
}

}  // namespace reseau
