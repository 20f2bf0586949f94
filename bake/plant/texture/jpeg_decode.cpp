// libjpeg can report an error only by a jump out of its own frames. Functions below that such a jump leaves have only locals without
// destructors; what needs a destructor belongs to the function that calls them.

#include "image_limits.h"

#include <csetjmp>
#include <cstdio>  // before jpeglib.h, which uses FILE
#include <string>

#include <jpeglib.h>
// It needs the declarations of jpeglib.h.
#include <jerror.h>

namespace coppice::bake {
namespace {

// A progressive image has about ten scans; each visits all of its coefficients.
constexpr int kMaxScans = 128;

struct JpegReader {
  jpeg_decompress_struct info{};
  jpeg_error_mgr errors{};
  std::jmp_buf failed{};
  int code = 0;  ///< the number of libjpeg's message; 0 for one of ours
  char message[JMSG_LENGTH_MAX] = "";

  JpegReader() = default;
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&info); }
};

[[noreturn]] void fail(j_common_ptr info) {
  auto& reader = *static_cast<JpegReader*>(info->client_data);
  reader.code = info->err->msg_code;
  info->err->format_message(info, reader.message);
  std::longjmp(reader.failed, 1);  // NOLINT(cert-err52-cpp)
}

[[noreturn]] void fail_with(JpegReader& reader, const char* message) {
  std::snprintf(reader.message, sizeof reader.message, "%s", message);
  std::longjmp(reader.failed, 1);  // NOLINT(cert-err52-cpp)
}

/// libjpeg warns and goes on with what it makes up. Only messages after which the pixels are as they were written are no errors.
void on_message(j_common_ptr info, int level) {
  if (level >= 0) return;
  switch (info->err->msg_code) {
    case JWRN_ADOBE_XFORM:
    case JWRN_BOGUS_ICC:
    case JWRN_EXTRANEOUS_DATA:
    case JWRN_JFIF_MAJOR:
    case JWRN_NOT_SEQUENTIAL:
      return;
    default:
      fail(info);
  }
}

bool read_header(JpegReader& reader, const std::uint8_t* bytes, std::size_t byte_count) {
  if (setjmp(reader.failed) != 0) return false;  // NOLINT(cert-err52-cpp)
  jpeg_create_decompress(&reader.info);
  jpeg_mem_src(&reader.info, bytes, byte_count);
  jpeg_read_header(&reader.info, TRUE);
  return true;
}

/// The components, as bits, whose block means are in the scan that starts.
unsigned started_components(const jpeg_decompress_struct& info) {
  unsigned components = 0;
  if (info.Ss == 0)
    for (int i = 0; i < info.comps_in_scan; ++i) components |= 1u << info.cur_comp_info[i]->component_index;
  return components;
}

/// Whether the scans of a progressive image have brought every bit of every coefficient.
bool is_refined(const jpeg_decompress_struct& info) {
  for (int component = 0; component < info.num_components; ++component)
    for (const int missing_bits : info.coef_bits[component])
      if (missing_bits != 0) return false;
  return true;
}

/// Reads all scans of an image that has several. A component without a scan would come out grey, one without its last scan coarse.
void read_scans(JpegReader& reader) {
  unsigned components = started_components(reader.info);
  for (int scan_count = 1;;) {
    const int event = jpeg_consume_input(&reader.info);
    if (event == JPEG_REACHED_EOI) break;
    if (event != JPEG_REACHED_SOS) continue;
    if (++scan_count > kMaxScans) fail_with(reader, "more than 128 scans");
    components |= started_components(reader.info);
  }
  if (components != (1u << reader.info.num_components) - 1) fail_with(reader, "a component has no scan");
  if (reader.info.progressive_mode != FALSE && !is_refined(reader.info)) fail_with(reader, "the last scans are missing");
}

/// rgba  [height * width * 4]; with four components it gets these
bool read_pixels(JpegReader& reader, std::uint8_t* rgba) {
  if (setjmp(reader.failed) != 0) return false;  // NOLINT(cert-err52-cpp)
  jpeg_decompress_struct& info = reader.info;
  info.out_color_space = info.num_components == 4 ? JCS_CMYK : JCS_EXT_RGBA;
  info.dct_method = JDCT_ISLOW;
  info.do_fancy_upsampling = TRUE;
  info.do_block_smoothing = FALSE;
  info.buffered_image = jpeg_has_multiple_scans(&info);
  jpeg_start_decompress(&info);
  if (info.buffered_image != FALSE) {
    read_scans(reader);
    jpeg_start_output(&info, info.input_scan_number);
  }
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = rgba + std::size_t{4} * info.output_width * info.output_scanline;
    jpeg_read_scanlines(&info, &row, 1);
  }
  if (info.buffered_image != FALSE) jpeg_finish_output(&info);
  jpeg_finish_decompress(&info);
  return true;
}

/// Turns CMYK to opaque RGBA. Adobe's writers store the inks inverted, and mark the file.
void mix_inks(std::vector<std::uint8_t>& pixels, bool is_inverted) {
  const unsigned flip = is_inverted ? 0 : 255;
  for (std::size_t i = 0; i < pixels.size(); i += 4) {
    const unsigned key = pixels[i + 3] ^ flip;
    for (std::size_t c = i; c < i + 3; ++c) pixels[c] = static_cast<std::uint8_t>(((pixels[c] ^ flip) * key + 127) / 255);
    pixels[i + 3] = 255;
  }
}

Error error_of(const JpegReader& reader) {
  const auto error = [&](Status status, const char* what) { return Error{status, what, Error::kNoOffset, reader.message}; };
  switch (reader.code) {
    case JERR_OUT_OF_MEMORY:
      return Error{Status::out_of_memory, "out of memory"};
    case JERR_ARITH_NOTIMPL:
    case JERR_BAD_PRECISION:
    case JERR_CONVERSION_NOTIMPL:
    case JERR_SOF_UNSUPPORTED:
      return error(Status::unsupported, "a kind of JPEG that is not read");
    case JERR_INPUT_EMPTY:
    case JERR_INPUT_EOF:
    case JERR_NO_IMAGE:
    case JERR_SOF_NO_SOS:
    case JWRN_HIT_MARKER:
    case JWRN_JPEG_EOF:
      return error(Status::bad_file, kImageEndsEarly);
    default:
      return error(Status::bad_file, kImageDamaged);
  }
}

/// Checks what the header promises.
Result<void> check_header(const jpeg_decompress_struct& info, std::size_t byte_count) {
  if (is_too_large(info.image_width, info.image_height)) return Error{Status::unsupported, kImageTooLarge};
  if (info.arith_code != FALSE || info.num_components == 2 || info.num_components > 4)
    return Error{Status::unsupported, "a kind of JPEG that is not read", Error::kNoOffset,
                 info.arith_code != FALSE ? "arithmetic coding" : std::to_string(info.num_components) + " components"};
  // A block of 8 x 8 pixels takes at least a bit.
  if (std::uint64_t{info.image_width / 8} * (info.image_height / 8) <= std::uint64_t{8} * byte_count) return {};
  return Error{Status::bad_file, kImageEndsEarly, Error::kNoOffset, "so few bytes cannot hold its pixels"};
}

}  // namespace

Result<Image> decode_jpeg(std::span<const std::uint8_t> bytes) {
  JpegReader reader;
  reader.info.err = jpeg_std_error(&reader.errors);
  reader.errors.error_exit = fail;
  reader.errors.emit_message = on_message;
  reader.info.client_data = &reader;
  if (!read_header(reader, bytes.data(), bytes.size())) return error_of(reader);
  COPPICE_CHECK(check_header(reader.info, bytes.size()));
  Image image;
  image.width = reader.info.image_width;
  image.height = reader.info.image_height;
  image.rgba.resize(std::size_t{4} * image.width * image.height);
  if (!read_pixels(reader, image.rgba.data())) return error_of(reader);
  if (reader.info.num_components == 4) mix_inks(image.rgba, reader.info.saw_Adobe_marker != FALSE);
  return image;
}

}  // namespace coppice::bake
