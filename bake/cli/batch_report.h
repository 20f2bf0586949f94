#pragma once

// What bake-all says of a batch, wherever it is baked. The page for people is batch_page/, embedded at build time (core/embed_texts.cmake).

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bake_batch.h"
#include "progress_bar.h"

namespace coppice::bake {

/// Everything about a batch that has ended.
struct Batch {
  std::filesystem::path output_folder;
  std::vector<BatchPlant> plants;
  std::vector<BatchResult> results;
  std::uint32_t job_count = 0;  ///< plants at a time; 0: on a cluster
  double seconds = 0.0;
  CacheReport cache;
};

/// Shows how far a batch is.
void show_batch(ProgressBar& bar, const BatchStatus& status);

std::size_t count_of(const Batch& batch, BatchOutcome outcome);

/// What --report writes: bake/README.md has the keys.
std::string batch_json(const Batch& batch);

/// What --html writes: a page that opens without a network. Pictures are those in the batch's picture_folder.
std::string batch_html(const Batch& batch);

/// A line for each plant, and one of all.
void print_batch(const Batch& batch);

/// With --explain, a line for each plant that was baked.
void print_reasons(const Batch& batch);

/// One line on stderr where something was wrong with the cache: what, and what was lost by it.
void print_cache_trouble(const CacheReport& report);

/// Why plants were not baked, to stderr. A plant's path, which most errors name too, is there once, as seen from the input's folder.
/// input  of the command: a folder, or a file in one; empty: plants have their whole paths
void print_failures(const Batch& batch, const std::filesystem::path& input);

}  // namespace coppice::bake
