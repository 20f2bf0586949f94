#pragma once

// What became of a batch, as a page for people: batch_page/, embedded at build time (core/embed_texts.cmake), with the batch's data.

#include <string>

#include "batch_report.h"

namespace coppice::bake {

/// A page that opens without a network. Pictures are those in the batch's picture_folder.
std::string batch_html(const Batch& batch);

}  // namespace coppice::bake
