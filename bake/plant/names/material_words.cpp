#include "material_words.h"

#include <algorithm>
#include <cstddef>

namespace coppice::bake {
namespace {

using enum WordKind;

constexpr MaterialWord kWords[]{
    {"leaf", leaf},
    {"leaves", leaf},
    {"foliage", leaf},
    {"foliole", leaf},
    {"needle", leaf},
    {"frond", leaf},
    {"canopy", leaf},
    {"grass", leaf},
    {"fern", leaf, true},
    {"ferns", leaf, true},
    {"ivy", leaf, true},
    {"lvs", leaf, true},
    {"blatt", leaf},
    {"blätt", leaf},
    {"laub", leaf},
    {"nadel", leaf},
    {"wedel", leaf},
    {"gras", leaf, true},
    {"feuill", leaf},
    {"aiguille", leaf},
    {"hoja", leaf},
    {"follaje", leaf},
    {"folha", leaf},
    {"foglia", leaf},
    {"foglie", leaf},
    {"blad", leaf},
    {"lehti", leaf},
    {"lehdet", leaf},
    {"yaprak", leaf},
    {"liść", leaf},
    {"liście", leaf},
    {"liscie", leaf},
    {"лист", leaf},
    {"хвоя", leaf},
    {"φύλλ", leaf},
    {"φυλλ", leaf},
    {"herbe", leaf},
    {"hierba", leaf},
    {"césped", leaf},
    {"erba", leaf, true},
    {"relva", leaf, true},
    {"gräs", leaf},
    {"trawa", leaf},
    {"трава", leaf},
    {"травы", leaf},
    {"γρασίδι", leaf},
    {"草", leaf},
    {"芝", leaf},
    {"잔디", leaf},
    {"farn", leaf, true},
    {"fougère", leaf},
    {"helecho", leaf},
    {"samambaia", leaf},
    {"felce", leaf},
    {"felci", leaf, true},
    {"varen", leaf, true},
    {"ormbunk", leaf},
    {"paproć", leaf},
    {"папоротник", leaf},
    {"φτέρη", leaf},
    {"蕨", leaf},
    {"シダ", leaf},
    {"고사리", leaf},
    {"aguja", leaf},
    {"agulha", leaf},
    {"aghi", leaf, true},
    {"naald", leaf},
    {"barr", leaf, true},
    {"neula", leaf},
    {"iğne", leaf},
    {"игла", leaf, true},
    {"иглы", leaf, true},
    {"βελόν", leaf},
    {"叶", leaf},
    {"葉", leaf},
    {"잎", leaf},

    {"petal", flower},
    {"flower", flower},
    {"blossom", flower},
    {"bloom", flower},
    {"blüte", flower},
    {"fleur", flower},
    {"pétale", flower},
    {"flor", flower, true},
    {"fiore", flower},
    {"bloem", flower},
    {"bloesem", flower},
    {"pétalo", flower},
    {"petalo", flower},
    {"blomma", flower},
    {"blommor", flower},
    {"kukka", flower, true},
    {"kukat", flower, true},
    {"çiçek", flower},
    {"kwiat", flower},
    {"цветок", flower},
    {"цветы", flower},
    {"лепест", flower},
    {"λουλούδ", flower},
    {"꽃", flower},
    {"花", flower},

    {"plant", plant, true},
    {"plants", plant, true},
    {"bush", plant, true},
    {"bushes", plant, true},
    {"shrub", plant, true},
    {"shrubs", plant, true},
    {"hedge", plant, true},
    {"vegetation", plant, true},
    {"greenery", plant, true},
    {"weed", plant, true},
    {"weeds", plant, true},
    {"reed", plant, true},
    {"reeds", plant, true},
    {"sedge", plant, true},
    {"moss", plant, true},
    {"clover", plant, true},
    {"seaweed", plant, true},
    {"kelp", plant, true},
    {"pflanze", plant, true},
    {"pflanzen", plant, true},
    {"busch", plant, true},
    {"büsche", plant, true},
    {"strauch", plant, true},
    {"hecke", plant, true},
    {"schilf", plant, true},
    {"plante", plant, true},
    {"plantes", plant, true},
    {"buisson", plant, true},
    {"haie", plant, true},
    {"roseau", plant, true},
    {"planta", plant, true},
    {"plantas", plant, true},
    {"arbusto", plant, true},
    {"arbustos", plant, true},
    {"seto", plant, true},
    {"junco", plant, true},
    {"sebe", plant, true},
    {"pianta", plant, true},
    {"piante", plant, true},
    {"cespuglio", plant, true},
    {"siepe", plant, true},
    {"canna", plant, true},
    {"struik", plant, true},
    {"heg", plant, true},
    {"riet", plant, true},
    {"växt", plant, true},
    {"buske", plant, true},
    {"häck", plant, true},
    {"kasvi", plant, true},
    {"pensas", plant, true},
    {"bitki", plant, true},
    {"çalı", plant, true},
    {"roślina", plant, true},
    {"krzew", plant, true},
    {"żywopłot", plant, true},
    {"растение", plant, true},
    {"растения", plant, true},
    {"куст", plant, true},
    {"кусты", plant, true},
    {"θάμνος", plant, true},
    {"灌木", plant},
    {"植物", plant},
    {"풀", plant},

    {"branch", twig},
    {"twig", twig},
    {"stem", twig, true},
    {"stems", twig, true},
    {"stalk", twig},
    {"shoot", twig},
    {"petiole", twig},
    {"rachis", twig},
    {"zweig", twig},
    {"ast", twig, true},
    {"äste", twig, true},
    {"stiel", twig},
    {"stängel", twig},
    {"rameau", twig},
    {"tige", twig, true},
    {"rama", twig, true},
    {"ramas", twig, true},
    {"ramo", twig, true},
    {"tallo", twig},
    {"caule", twig, true},
    {"gambo", twig, true},
    {"tak", twig, true},
    {"takken", twig, true},
    {"gren", twig, true},
    {"oksa", twig, true},
    {"gałąź", twig},
    {"ветк", twig},
    {"ветв", twig},
    {"枝", twig},

    {"bark", other},
    {"trunk", other},
    {"wood", other},
    {"timber", other},
    {"stump", other},
    {"log", other, true},
    {"root", other, true},
    {"roots", other, true},
    {"rinde", other, true},
    {"borke", other},
    {"stamm", other},
    {"holz", other},
    {"wurzel", other},
    {"écorce", other},
    {"ecorce", other},
    {"tronc", other},
    {"bois", other, true},
    {"racine", other},
    {"corteza", other},
    {"madera", other},
    {"casca", other, true},
    {"madeira", other},
    {"corteccia", other},
    {"legno", other},
    {"radice", other},
    {"schors", other},
    {"stam", other, true},
    {"hout", other, true},
    {"kora", other, true},
    {"pień", other, true},
    {"кора", other, true},
    {"ствол", other},
    {"树皮", other},
    {"樹皮", other},
    {"树干", other},
    {"樹幹", other},
    {"幹", other},
    {"pot", other, true},
    {"planter", other},
    {"vase", other, true},
    {"soil", other},
    {"ground", other},
    {"dirt", other},
    {"earth", other, true},
    {"terrain", other},
    {"rock", other},
    {"stone", other},
    {"gravel", other},
    {"pebble", other},
    {"snow", other},
    {"fruit", other},
    {"berry", other, true},
    {"berries", other, true},
    {"acorn", other},
    {"cone", other, true},
    {"cones", other, true},
    {"nut", other, true},
    {"nuts", other, true},
    {"coconut", other},
    {"seed", other, true},
    {"seeds", other, true},
    {"topf", other},
    {"erde", other, true},
    {"boden", other},
    {"frucht", other},
    {"früchte", other},
    {"schnee", other},
    {"terre", other, true},
    {"neige", other},
    {"fruta", other},
    {"fruto", other},
    {"frutto", other},
    {"maceta", other},
    {"suelo", other},
    {"nieve", other},
    {"terra", other, true},
    {"neve", other, true},
};

double worth(WordKind kind) {
  switch (kind) {
    case leaf:
      return 3.0;
    case flower:
    case plant:
      return 1.0;
    case twig:
      return -1.0;
    case other:
      break;
  }
  return -3.0;
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

bool contains(const std::string& words, const MaterialWord& word) {
  if (!word.whole) return words.find(word.text) != std::string::npos;
  return words.find(" " + std::string(word.text) + " ") != std::string::npos;
}

bool has(const std::string& words, WordKind kind) {
  return std::ranges::any_of(kWords, [&](const MaterialWord& word) { return word.kind == kind && contains(words, word); });
}

double evidence_of_parts(const std::string& words) {
  double sum = 0.0;
  for (const WordKind kind : {leaf, flower, twig, other})
    if (has(words, kind)) sum += worth(kind);
  return sum;
}

}  // namespace

std::span<const MaterialWord> material_words() {
  return kWords;
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
