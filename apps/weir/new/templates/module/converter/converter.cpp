// The converter my-converter: the numbers of a line of text, "1 2 3", become an int32 tensor.
// <weir/converter.hpp> documents the other members that a class may have.
#include <weir/converter.hpp>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

class MyConverter {
 public:
  explicit MyConverter(const weir::Options&) {}

  // The tensors of each frame, for these caps; none: the first frame decides.
  std::vector<weir_tensor_info> configure(std::string_view) { return {}; }

  // Returns false to drop the frame. Throw weir::Failure for an error that users see as it is.
  bool convert(const weir_frame& frame, weir::ConverterOutput& output) {
    std::string text;
    for (uint32_t i = 0; i < frame.n_tensors; ++i)
      text.append(static_cast<const char*>(frame.tensors[i].data), frame.tensors[i].bytes);
    std::vector<int32_t> numbers;
    std::istringstream words(text);
    for (int32_t number = 0; words >> number;) numbers.push_back(number);
    if (numbers.empty()) return false;
    const auto count = static_cast<int64_t>(numbers.size());
    const auto to = output.add(weir::dense_tensor(WEIR_INT32, {count}));
    std::copy_n(reinterpret_cast<const std::byte*>(numbers.data()), to.size(), to.begin());
    return true;
  }
};
// Name, other names, the caps of what goes in, options.
WEIR_CONVERTER(MyConverter, "my-converter", "",
               "application/x-my-converter, framerate=(fraction)[ 0/1, 2147483647/1 ]", "[]")
