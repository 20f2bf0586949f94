#include "material_words.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace coppice::bake {
namespace {

using enum WordKind;

constexpr std::string_view kLeafParts[] = {
    "leaf",      "leaves", "foliage", "foliole",  "needle",     "frond",   "canopy", "grass",  "blatt",  "blätt",   "laub",
    "nadel",     "wedel",  "feuill",  "aiguille", "hoja",       "follaje", "folha",  "foglia", "foglie", "blad",    "lehti",
    "lehdet",    "yaprak", "liść",    "liście",   "liscie",     "лист",    "хвоя",   "φύλλ",   "φυλλ",   "herbe",   "hierba",
    "césped",    "gräs",   "trawa",   "трава",    "травы",      "γρασίδι", "草",     "芝",     "잔디",   "fougère", "helecho",
    "samambaia", "felce",  "ormbunk", "paproć",   "папоротник", "φτέρη",   "蕨",     "シダ",   "고사리", "aguja",   "agulha",
    "naald",     "neula",  "iğne",    "βελόν",    "叶",         "葉",      "잎"};
constexpr std::string_view kLeafWholeWords[] = {"fern", "ferns", "ivy",   "lvs",  "gras", "erba", "relva",
                                                "farn", "felci", "varen", "aghi", "barr", "игла", "иглы"};
constexpr std::string_view kFlowerParts[] = {"petal",  "flower",  "blossom", "bloom",   "blüte",  "fleur",   "pétale", "fiore",
                                             "bloem",  "bloesem", "pétalo",  "petalo",  "blomma", "blommor", "çiçek",  "kwiat",
                                             "цветок", "цветы",   "лепест",  "λουλούδ", "꽃",     "花"};
constexpr std::string_view kFlowerWholeWords[] = {"flor", "kukka", "kukat"};
constexpr std::string_view kPlantParts[] = {"灌木", "植物", "풀"};
constexpr std::string_view kPlantWholeWords[] = {
    "plant",  "plants", "bush",    "bushes",    "shrub",   "shrubs", "hedge",    "vegetation", "greenery", "weed",     "weeds",   "reed",
    "reeds",  "sedge",  "moss",    "clover",    "seaweed", "kelp",   "pflanze",  "pflanzen",   "busch",    "büsche",   "strauch", "hecke",
    "schilf", "plante", "plantes", "buisson",   "haie",    "roseau", "planta",   "plantas",    "arbusto",  "arbustos", "seto",    "junco",
    "sebe",   "pianta", "piante",  "cespuglio", "siepe",   "canna",  "struik",   "heg",        "riet",     "växt",     "buske",   "häck",
    "kasvi",  "pensas", "bitki",   "çalı",      "roślina", "krzew",  "żywopłot", "растение",   "растения", "куст",     "кусты",   "θάμνος"};
constexpr std::string_view kTwigParts[] = {"branch",  "twig",   "stalk", "shoot", "petiole", "rachis", "zweig", "stiel",
                                           "stängel", "rameau", "tallo", "gałąź", "ветк",    "ветв",   "枝"};
constexpr std::string_view kTwigWholeWords[] = {"stem", "stems", "ast",   "äste", "tige",   "rama", "ramas",
                                                "ramo", "caule", "gambo", "tak",  "takken", "gren", "oksa"};
constexpr std::string_view kOtherParts[] = {
    "bark",    "trunk",  "wood",    "timber",    "stump",   "borke",  "stamm",  "holz",   "wurzel", "écorce", "ecorce", "tronc", "racine",
    "corteza", "madera", "madeira", "corteccia", "legno",   "radice", "schors", "ствол",  "树皮",   "樹皮",   "树干",   "樹幹",  "幹",
    "planter", "soil",   "ground",  "dirt",      "terrain", "rock",   "stone",  "gravel", "pebble", "snow",   "fruit",  "acorn", "coconut",
    "topf",    "boden",  "frucht",  "früchte",   "schnee",  "neige",  "fruta",  "fruto",  "frutto", "maceta", "suelo",  "nieve"};
constexpr std::string_view kOtherWholeWords[] = {"log",  "root", "roots", "rinde", "bois",  "casca", "stam",    "hout", "kora",
                                                 "pień", "кора", "pot",   "vase",  "earth", "berry", "berries", "cone", "cones",
                                                 "nut",  "nuts", "seed",  "seeds", "erde",  "terre", "terra",   "neve"};

constexpr MaterialWords kGroups[] = {{leaf, false, kLeafParts},         {leaf, true, kLeafWholeWords}, {flower, false, kFlowerParts},
                                     {flower, true, kFlowerWholeWords}, {plant, false, kPlantParts},   {plant, true, kPlantWholeWords},
                                     {twig, false, kTwigParts},         {twig, true, kTwigWholeWords}, {other, false, kOtherParts},
                                     {other, true, kOtherWholeWords}};

/// What a word of a kind speaks for: by WordKind, leaves above 0 and wood below.
constexpr std::array kWorth{3.0, 1.0, 1.0, -1.0, -3.0};

double worth(WordKind kind) {
  return kWorth.at(static_cast<std::size_t>(kind));
}

bool is_capital(char c) {
  return c >= 'A' && c <= 'Z';
}
bool is_small(char c) {
  return c >= 'a' && c <= 'z';
}

/// Two bytes of UTF-8 in lower case, for the capitals of Latin-1, Greek and Russian.
void lower_pair(unsigned char& lead, unsigned char& next) {
  if (lead == 0xc3 && next >= 0x80 && next <= 0x9e) next = static_cast<unsigned char>(next + 0x20);               // À..Þ
  if (lead == 0xce && next >= 0x91 && next <= 0x9f) next = static_cast<unsigned char>(next + 0x20);               // Α..Ο
  if (lead == 0xce && next >= 0xa0 && next <= 0xa9) lead = 0xcf, next = static_cast<unsigned char>(next - 0x20);  // Π..Ω
  if (lead == 0xd0 && next >= 0x90 && next <= 0x9f) next = static_cast<unsigned char>(next + 0x20);               // А..П
  if (lead == 0xd0 && next >= 0xa0 && next <= 0xaf) lead = 0xd1, next = static_cast<unsigned char>(next - 0x20);  // Р..Я
}

/// The name in lower case, with single spaces between words and at either end.
std::string spaced(std::string_view name) {
  std::string words = " ";
  char before = ' ';
  for (const char c : name.substr(0, kMaxNameBytes)) {
    const bool letter = is_capital(c) || is_small(c) || static_cast<unsigned char>(c) >= 0x80;
    const bool new_word = is_capital(c) && is_small(before);
    before = c;
    if ((!letter || new_word) && words.back() != ' ') words += ' ';
    if (letter) words += is_capital(c) ? static_cast<char>(c - 'A' + 'a') : c;
  }
  if (words.back() != ' ') words += ' ';
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    auto lead = static_cast<unsigned char>(words[i]), next = static_cast<unsigned char>(words[i + 1]);
    lower_pair(lead, next);
    words[i] = static_cast<char>(lead);
    words[i + 1] = static_cast<char>(next);
  }
  return words;
}

bool has(const std::string& words, WordKind kind) {
  return std::ranges::any_of(kGroups, [&](const MaterialWords& group) {
    return group.kind == kind && std::ranges::any_of(group.texts, [&](std::string_view text) {
             return words.find(group.whole ? " " + std::string(text) + " " : std::string(text)) != std::string::npos;
           });
  });
}

double evidence_of_parts(const std::string& words) {
  double sum = 0.0;
  for (const WordKind kind : {leaf, flower, twig, other})
    if (has(words, kind)) sum += worth(kind);
  return sum;
}

}  // namespace

std::span<const MaterialWords> material_words() {
  return kGroups;
}

double name_evidence(std::string_view name) {
  const std::string words = spaced(name);
  const double parts = evidence_of_parts(words);
  // A word for a plant is part of what else the name says: "plant_pot".
  return parts == 0.0 && has(words, plant) ? worth(plant) : parts;
}

double part_evidence(std::string_view name) {
  return evidence_of_parts(spaced(name));
}

}  // namespace coppice::bake
