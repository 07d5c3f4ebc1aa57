// Messages and descriptors between two processes: a pair of sockets that keep messages apart (SOCK_SEQPACKET). What
// comes in is not believed: a message that is too long, or that has other descriptors than asked for, is none.
#pragma once

#include <chrono>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/sandbox/descriptor.h"

namespace meshgauge::server::sandbox {

inline constexpr std::size_t kMaxMessageBytes = std::size_t{16} << 10;

struct Channel {
  Descriptor ours;
  Descriptor theirs;
};

std::optional<Channel> open_channel();  // both ends are closed on exec; nullopt: no descriptors are left

struct Message {
  std::string bytes;
  std::vector<Descriptor> files;
};

// At most two files, which stay the caller's. False when the other end is closed or its buffer is full; never waits.
bool send_message(int socket, std::string_view bytes, std::initializer_list<int> files = {});

// Waits at most `time` until a message can be received, or nothing will come any more.
bool readable(int socket, std::chrono::milliseconds time);

// Waits. nullopt: the other end is closed (or sent an empty message), or what came does not fit or has not exactly
// `files` descriptors, of which there are at most two. With `files` 0 whatever is sent along never enters this process.
std::optional<Message> receive_message(int socket, std::size_t files);

}  // namespace meshgauge::server::sandbox
