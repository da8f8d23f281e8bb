// What an engine said of an output, against what it says now.
#include "elements/tensor_filter/output_size.hpp"

#include <algorithm>

#include "elements/tensor_filter/model_info.hpp"

namespace weir {

bool same_shape(const weir_tensor_info& a, const weir_tensor_info& b) noexcept {
  return a.type == b.type && a.rank == b.rank &&
         std::equal(a.shape, a.shape + std::min<uint32_t>(a.rank, WEIR_RANK_LIMIT), b.shape);
}

Error changed_size(size_t index, const weir_tensor_info& given, const ModelShape& told) {
  return Error{Code::INVOKE_FAILED,
               "the model changed the size of an output",
               model_shape(given).to_string(),
               told.to_string(),
               "tensor " + std::to_string(index),
               "tensor_filter invoke-dynamic=true"};
}

}  // namespace weir
