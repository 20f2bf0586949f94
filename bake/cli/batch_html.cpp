#include "batch_html.h"

#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "batch_page.h"
#include "html_page.h"
#include "output.h"
#include "plant_pictures.h"

namespace coppice::bake {

std::string batch_html(const Batch& batch) {
  nlohmann::ordered_json record = batch_record(batch);
  record["folder"] = shown(batch.output_folder);
  const std::filesystem::path pictures = picture_folder(batch.output_folder);
  for (std::size_t i = 0; i < batch.plants.size(); ++i) {
    record["plants"][i]["name"] = plant_label(batch, i);
    if (batch.results[i].outcome == BatchOutcome::failed) continue;
    if (const auto picture = read_file(picture_path(pictures, batch.results[i].key)))
      record["plants"][i]["picture"] = data_url("image/webp", *picture);
  }
  const std::string data = json_for_script(record.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  const std::pair<std::string_view, std::string_view> parts[] = {
      {"{{style}}", batch_page::kStyle}, {"{{data}}", data}, {"{{script}}", batch_page::kScript}};
  return filled_page(batch_page::kPage, parts);
}

}  // namespace coppice::bake
