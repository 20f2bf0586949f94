#include "output.h"

#include <cstdlib>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

#include "atomic_file.h"
#include "failure.h"
#include "taken_places.h"

namespace forest {
namespace {

namespace files = coppice::bake;

template <class T>
T must(coppice::Result<T> result) {
  if (!result) throw Failure(result.error().message());
  return *std::move(result);
}

void must(const coppice::Result<void>& result) {
  if (!result) throw Failure(result.error().message());
}

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

void check_outputs(std::span<const NamedOutput> outputs, std::span<const std::string> inputs) {
  files::TakenPlaces taken;
  for (const std::string& input : inputs) must(taken.add(input));
  for (const auto& [option, file] : outputs) try {
      if (file.empty()) continue;
      if (!must(taken.add(file))) throw Failure(file + " would be overwritten: it is read, or another output");
      must(files::make_folder_of(file));
      must(files::try_writing(file));
    } catch (const Failure& failure) {
      throw Failure(std::string(option) + ": " + failure.what());
    }
}

void write_output(const std::string& file, std::string_view bytes) {
  static_cast<void>(start_output(file, bytes));
}

GrowingOutput start_output(const std::string& file, std::string_view start) {
  must(files::make_folder_of(file));
  files::TemporaryFile staged = must(files::stage_file(file, bytes_of(start)));
  must(staged.publish());
  return {file, staged.take_open_file()};
}

void add(const GrowingOutput& output, std::string_view bytes) {
  if (output.open.number() >= 0) must(files::write_all(output.open.number(), bytes_of(bytes), output.file));
}

void write_png(const std::string& file, std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> rgba) {
  std::vector<std::uint8_t> rgb(std::size_t{width} * height * 3);
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i)
    for (std::size_t channel = 0; channel < 3; ++channel) rgb[3 * i + channel] = rgba[4 * i + channel];
  const auto w = static_cast<int>(width);
  int bytes = 0;
  const std::unique_ptr<unsigned char, void (*)(void*)> png(
      stbi_write_png_to_mem(rgb.data(), 3 * w, w, static_cast<int>(height), 3, &bytes), std::free);
  if (!png) throw std::bad_alloc();
  write_output(file, {reinterpret_cast<const char*>(png.get()), static_cast<std::size_t>(bytes)});
}

}  // namespace forest
