// The operators that are lowered, each by a function that adds its nodes to the graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "lowering/lowered_graph.hpp"

namespace weir::engine {

// MODEL_UNSUPPORTED; its `offered` gives the part of the operator that is not lowered.
using LowerOperator = Status (*)(LoweredGraph&, const TfliteGraphOperator&);

struct KnownOperator {
  int32_t code;  // BuiltinOperator
  const char* name;
  LowerOperator lower;  // null: not lowered
};
// Null for an unknown number.
const KnownOperator* known_operator(int32_t code);

// convolutions.cpp
Status lower_convolution(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_depthwise_convolution(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_transposed_convolution(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_fully_connected(LoweredGraph& graph, const TfliteGraphOperator& op);
// pooling.cpp
Status lower_average_pool(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_max_pool(LoweredGraph& graph, const TfliteGraphOperator& op);
// elementwise.cpp
Status lower_add(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_multiply(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_logistic(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_softmax(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_quantize(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_dequantize(LoweredGraph& graph, const TfliteGraphOperator& op);
// subtract.cpp
Status lower_subtract(LoweredGraph& graph, const TfliteGraphOperator& op);
// data_movement.cpp: operators that move values without computing
Status lower_reshape(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_concatenation(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_pad(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_strided_slice(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_nearest_neighbour(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_bilinear(LoweredGraph& graph, const TfliteGraphOperator& op);
// gather.cpp
Status lower_gather(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_gather_nd(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_pack(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_unpack(LoweredGraph& graph, const TfliteGraphOperator& op);
// unquantised_operators.cpp
Status lower_arg_max(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_cast(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_divide(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_floor_divide(LoweredGraph& graph, const TfliteGraphOperator& op);
Status lower_square_root(LoweredGraph& graph, const TfliteGraphOperator& op);
// ADD, MUL and others on values without quantisation.
Status plain_binary(LoweredGraph& graph, const TfliteGraphOperator& op, std::string_view name);

}  // namespace weir::engine
