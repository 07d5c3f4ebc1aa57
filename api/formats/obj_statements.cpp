#include "api/formats/obj_statements.h"

#include <algorithm>
#include <string>

#include "api/formats/source.h"
#include "api/formats/text.h"

namespace meshgauge::api {
namespace {

struct Statement {
  std::string_view word;
  ObjRole role;
  std::string_view kind = {};  // of a surface, for Unread
};

// Those that place or join vertices: written otherwise, they are a mistake that changes the surface or its groups.
constexpr Statement kShapes[] = {
    {"vt", ObjRole::beside_points},
    {"vn", ObjRole::beside_points},
    {"l", ObjRole::line},
    {"p", ObjRole::line},
    {"v", ObjRole::unknown},
    {"f", ObjRole::unknown},
    {"fo", ObjRole::unknown},
    {"g", ObjRole::unknown},
    {"o", ObjRole::unknown},
    {"vp", ObjRole::attribute},
    {"curv2", ObjRole::line},  // before "curv", with which it begins
    {"curv", ObjRole::line},
    {"cdc", ObjRole::line},
    {"surf", ObjRole::surface, "free-form surfaces (surf)"},
    {"bzp", ObjRole::surface, "Bezier patches (bzp)"},
    {"bsp", ObjRole::surface, "B-spline patches (bsp)"},
    {"cdp", ObjRole::surface, "Cardinal patches (cdp)"},
    {"call", ObjRole::surface, "included files (call)"},
    {"csh", ObjRole::surface, "commands (csh)"},
};
constexpr Statement kOthers[] = {{"s", ObjRole::beside_points},
                                 {"usemtl", ObjRole::beside_points},
                                 {"mtllib", ObjRole::beside_points},
                                 {"usemap", ObjRole::attribute},
                                 {"maplib", ObjRole::attribute},
                                 {"mg", ObjRole::attribute},
                                 {"lod", ObjRole::attribute},
                                 {"bevel", ObjRole::attribute},
                                 {"c_interp", ObjRole::attribute},
                                 {"d_interp", ObjRole::attribute},
                                 {"ctech", ObjRole::attribute},
                                 {"stech", ObjRole::attribute},
                                 {"shadow_obj", ObjRole::attribute},
                                 {"trace_obj", ObjRole::attribute},
                                 {"cstype", ObjRole::attribute},
                                 {"deg", ObjRole::attribute},
                                 {"bmat", ObjRole::attribute},
                                 {"step", ObjRole::attribute},
                                 {"parm", ObjRole::attribute},
                                 {"trim", ObjRole::attribute},
                                 {"hole", ObjRole::attribute},
                                 {"scrv", ObjRole::attribute},
                                 {"sp", ObjRole::attribute},
                                 {"end", ObjRole::attribute},
                                 {"con", ObjRole::attribute},
                                 {"res", ObjRole::attribute},
                                 {"vc", ObjRole::attribute},  // colours
                                 {"vw", ObjRole::attribute},  // weights of joints
                                 // Materials, which belong into a file of their own.
                                 {"newmtl", ObjRole::attribute},
                                 {"ka", ObjRole::attribute},
                                 {"kd", ObjRole::attribute},
                                 {"ks", ObjRole::attribute},
                                 {"ke", ObjRole::attribute},
                                 {"ns", ObjRole::attribute},
                                 {"ni", ObjRole::attribute},
                                 {"tr", ObjRole::attribute},
                                 {"tf", ObjRole::attribute},
                                 {"d", ObjRole::attribute},
                                 {"illum", ObjRole::attribute},
                                 {"sharpness", ObjRole::attribute},
                                 {"bump", ObjRole::attribute},
                                 {"disp", ObjRole::attribute},
                                 {"decal", ObjRole::attribute},
                                 {"refl", ObjRole::attribute}};

const Statement* shape(std::string_view word) {
  const auto found = std::ranges::find(kShapes, word, &Statement::word);
  return found == std::end(kShapes) ? nullptr : found;
}

// What joins a number to the letters; "f_name" and "p:" may be other words.
bool is_joined(char next) {
  return is_digit(next) || std::string_view("+-.,;(/\\").find(next) != std::string_view::npos;
}

}  // namespace

bool is_shape(std::string_view word) { return shape(word) != nullptr; }

ObjRole role_of_obj(std::string_view word) {
  if (const Statement* known = shape(word)) return known->role;
  if (same_word(word.substr(0, 4), "map_")) return ObjRole::attribute;
  for (const Statement& other : kOthers) {
    if (same_word(word, other.word)) return other.role;  // "USEMTL red" is no surface either
  }
  return ObjRole::unknown;
}

std::string_view meant_statement(std::string_view word) {
  for (const Statement& known : kShapes) {
    const std::size_t length = known.word.size();
    if (!same_word(word.substr(0, length), known.word)) continue;
    const bool names_group = known.word == "g" || known.word == "o";
    if (word.size() == length || (is_joined(word[length]) && !names_group)) return known.word;
  }
  return {};
}

void UnreadStatements::add(std::string_view word) {
  const auto known = std::ranges::find(words_, word, [](const auto& one) { return one.first; });
  if (known != words_.end()) {
    ++known->second;
  } else if (words_.size() < Unread::kMostKinds) {
    words_.emplace_back(word, 1);
  } else {
    ++others_;
  }
}

void UnreadStatements::move_to(Unread& unread) {
  constexpr std::size_t kLongestWord = 32;
  for (const auto& [word, count] : words_) {
    const Statement* known = shape(word);
    const std::string unknown = "unknown statements (" + printable(word, kLongestWord) + ")";
    unread.add(known != nullptr ? known->kind : unknown, count);
  }
  if (others_ > 0) unread.add("other unknown statements", others_);
  words_.clear();
  others_ = 0;
}

}  // namespace meshgauge::api
