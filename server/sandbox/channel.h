// Messages and descriptors between two processes, over a pair of sockets that keep message boundaries
// (SOCK_SEQPACKET). Received data is untrusted: a message that is too long, or carries another number of descriptors
// than expected, is rejected.
#pragma once

#include <chrono>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/descriptor.h"
#include "engine/control.h"

namespace meshgauge::server::sandbox {

inline constexpr std::chrono::milliseconds kTick{10};  // interval at which waiting functions check `interrupted`
inline constexpr std::size_t kMaxMessageBytes = std::size_t{16} << 10;

struct Channel {
  Descriptor ours;
  Descriptor theirs;
};

std::optional<Channel> open_channel();  // both ends close on exec; nullopt: no descriptors left

struct Message {
  std::string bytes;
  std::vector<Descriptor> files;
};

// Sends a message with at most two descriptors, which stay open here. False: the other end is closed, or its buffer
// is full. Does not block.
bool send_message(int socket, std::string_view bytes, std::initializer_list<int> files = {});

// Waits up to `time` until a message can be received or the other end is closed. False: neither.
bool readable(int socket, std::chrono::milliseconds time);

// As above; returns false within kTick when `interrupted` is true.
bool readable(int socket, std::chrono::milliseconds time, const Interrupted& interrupted);

// Whether the other end is closed, or its process ends within kTick. Messages sent before may still be received.
bool closed(int socket);

// Receives a message. Blocks. nullopt: the other end is closed or sent an empty message, the message does not fit, or
// it does not carry exactly `files` descriptors (at most two). With `files` 0 no descriptor enters this process.
std::optional<Message> receive_message(int socket, std::size_t files);

}  // namespace meshgauge::server::sandbox
