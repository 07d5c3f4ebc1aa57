// Compressed files made by the tests: gzip; zip archives, field by field, so that each can be false; 3MF packages.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace meshgauge::api::test {

std::string gzipped(std::string_view content);

struct ZipEntry {
  std::string name;
  std::string content;
  std::uint16_t method = 8;    // 0: stored, 8: deflated
  std::uint16_t flags = 0;     // 1: encrypted
  std::uint32_t size_lie = 0;  // added to the size that is announced
  std::uint32_t crc_lie = 0;   // added to the CRC
  bool in_zip64 = false;       // sizes and offset in a Zip64 field, between two others; size_lie goes there
  std::uint64_t size_lie_64 = 0;
};

std::string zip(const std::vector<ZipEntry>& entries, const std::string& comment = "");

// Returns the archive with Zip64 records at its end that announce `count` entries.
std::string zip64(const std::vector<ZipEntry>& entries, std::uint64_t count);

// The relationships that name `target` as the root model.
std::string relationships(const std::string& target = "/3D/3dmodel.model");

// A model of the core namespace; `attributes`: additional attributes of its root element.
std::string model(const std::string& resources, const std::string& build, const std::string& attributes = "");

// An object of one mesh: the triangle (0 0 0) (1 0 0) (0 1 0).
std::string triangle_object(int id);

// A 3MF with one model and further parts.
std::string package(const std::string& model, std::vector<ZipEntry> more = {});

}  // namespace meshgauge::api::test
