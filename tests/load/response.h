// A response as far as it matters to a client that loads: its status, its length, and whether the connection goes on.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

constexpr int kBroken = -2;  // status of what is not understood, or was cut off

class Response {
 public:
  // Gives true at the end of the response. What is not understood ends it with status kBroken.
  bool take(std::string_view bytes) {
    if (!headed_) {
      head_.append(bytes);
      std::size_t end = head_.find(kEnd);
      if (end != std::string::npos && head_.starts_with("HTTP/1.1 100 ")) {
        invited_ = true;
        head_.erase(0, end + kEnd.size());
        end = head_.find(kEnd);
      }
      if (end == std::string::npos) return false;
      headed_ = true;
      parse(std::string_view(head_).substr(0, end + 2));
      bytes = std::string_view(head_).substr(end + kEnd.size());
    }
    left_ -= std::min<std::uint64_t>(left_, bytes.size());
    return left_ == 0;
  }

  bool begun() const { return invited_ || !head_.empty(); }
  bool invited() const { return invited_; }  // 100 Continue has come: the body may follow
  int status() const { return status_; }
  bool closes() const { return closes_; }

 private:
  static constexpr std::string_view kEnd = "\r\n\r\n";

  void parse(std::string_view head) {
    status_ = kBroken;
    if (head.starts_with("HTTP/1.1 ")) std::from_chars(head.data() + 9, head.data() + head.size(), status_);
    left_ = 0;
    if (const auto length = value_of(head, "\r\nContent-Length: "); !length.empty()) {
      std::from_chars(length.data(), length.data() + length.size(), left_);
    }
    closes_ = value_of(head, "\r\nConnection: ") == "close";
  }

  static std::string_view value_of(std::string_view head, std::string_view name) {
    const std::size_t at = head.find(name);
    if (at == std::string_view::npos) return {};
    head.remove_prefix(at + name.size());
    return head.substr(0, head.find("\r\n"));
  }

  std::string head_;
  bool headed_ = false;
  bool invited_ = false;
  int status_ = kBroken;
  std::uint64_t left_ = 0;
  bool closes_ = false;
};
