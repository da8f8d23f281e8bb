// ClassLabels: the names of classes that tensor_decoder receives with a stream of results, or sends
// with the results that it makes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "elements/tensor_decoder/frame_decoder.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir {

// Used on the streaming thread.
class ClassLabels {
 public:
  // A new stream.
  void clear();
  // Keeps the labels of an event and passes them to `decoder`, which may be null. Other events have
  // no effect.
  void receive(GstEvent* event, FrameDecoder* decoder);
  // Passes the labels of the stream to a decoder that has just been opened.
  void pass_to(FrameDecoder* decoder) const;
  // Classes of the decoder's model that have no label; each finding once. `file`: the property
  // labels.
  std::optional<Error> missing(const FrameDecoder& decoder, const std::string& file);
  // Sends the labels of the decoder's results downstream, unless that has been done.
  void send(const FrameDecoder& decoder, const std::string& source, GstPad* pad);

  // Fills in the labels of the model's card if the model does not name its classes itself.
  void add_card_labels(DescribedModel* model);

 private:
  std::map<std::string, gst::LabelsOfSource> received_;  // by source
  gst::LabelsOfSource sent_;
  std::string reported_;  // by missing()
  // The card is looked up once for each model.
  std::string card_of_;
  std::vector<std::string> card_labels_;
};

}  // namespace weir
