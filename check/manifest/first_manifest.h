// Writes the first manifest of a folder with meshes: `meshgauge check --init`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/result.h"

namespace meshgauge::check {

inline constexpr const char* kManifestName = "gates.yaml";

struct FirstManifest {
  std::string text;
  std::vector<std::string> left_out;  // sentences: folders that no gate can name
};

// Looks for meshes in the folder and in the folders directly in it. Two folders with files of the same names become
// candidates and baselines; other meshes are candidates whose baselines are to be made by --update-baselines. Every
// capitalisation of a suffix is taken. `limit`: the text of max_distance. Errors: the folder cannot be read, or has no
// mesh.
Result<FirstManifest> first_manifest(const std::filesystem::path& folder, const std::string& limit);

// Return a gate in one line, for a message: the candidates are all files of a folder, or one file; all meshes directly
// in the folder.
std::string example_gate(const std::vector<std::string>& candidates, const std::string& baselines);
std::string example_gate_of_folder(const std::string& folder, const std::string& baselines);

}  // namespace meshgauge::check
