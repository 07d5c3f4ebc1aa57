#include "s3_double.h"

#include <fcntl.h>
#include <httplib.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <stdexcept>

#include "api/base/digest.h"

namespace meshgauge::server::store {
namespace {

using nlohmann::json;

constexpr const char* kAccessKey = "AKIDEXAMPLE";
constexpr const char* kSecretKey = "wJalrXUtnFEMI/K7MDENG+bPxRfiCYEXAMPLEKEY=";
constexpr const char* kRegion = "eu-test-1";
constexpr const char* kBucket = "meshes-of-tests";
constexpr const char* kScript = MESHGAUGE_SOURCE_DIR "/tests/server/store/s3/s3_double.py";

struct Pipe {
  Descriptor out, in;
  Pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    out = Descriptor(ends[0]);
    in = Descriptor(ends[1]);
  }
};

pid_t spawn(const std::vector<std::string>& words, int input, int output) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (input >= 0) posix_spawn_file_actions_adddup2(&actions, input, 0);
  if (output >= 0) posix_spawn_file_actions_adddup2(&actions, output, 1);
  if (output < 0) posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  pid_t process = -1;
  const int failed = ::posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error("cannot start " + words[0]);
  return process;
}

void run(const std::vector<std::string>& words) {
  int status = 0;
  const pid_t process = spawn(words, -1, -1);
  if (::waitpid(process, &status, 0) != process || status != 0) throw std::runtime_error(words[0] + " has failed");
}

// The double is local, so no proxy is used. Set before threads start.
const int kWithoutProxy = ::setenv("no_proxy", "*", 1);

// For "localhost", with its key in the same file.
std::string make_certificate() {
  std::string file = (std::filesystem::temp_directory_path() / ("meshgauge-s3-" + api::random_id() + ".pem")).string();
  run({"openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "1",
       "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost", "-keyout", file + ".key", "-out", file,
       "-batch"});
  return file;
}

}  // namespace

S3Double::S3Double(const Kind& kind) : kind_(kind) {
  json account{{"access_key", kAccessKey},
               {"secret_key", kSecretKey},
               {"token", kind.token},
               {"region", kRegion},
               {"bucket", kBucket}};
  if (kind_.tls) account["certificate"] = certificate_ = make_certificate();
  if (kind_.tls) account["key"] = certificate_ + ".key";
  start(account.dump());
}

void S3Double::start(const std::string& account) {
  Pipe input;
  Pipe output;
  process_ = spawn({"/usr/bin/python3", "-B", kScript, account}, input.out.get(), output.in.get());
  input_ = std::move(input.in);
  output.in.close();
  std::string line;
  char c = 0;
  while (::read(output.out.get(), &c, 1) == 1 && c != '\n') line += c;
  if (line.empty()) throw std::runtime_error("the double of S3 does not start");
  port_ = std::stoi(line);
}

S3Double::~S3Double() {
  input_.close();
  ::waitpid(process_, nullptr, 0);
  if (!certificate_.empty()) {
    std::filesystem::remove(certificate_);
    std::filesystem::remove(certificate_ + ".key");
  }
}

S3Settings S3Double::settings() const {
  S3Settings settings;
  const bool named = kind_.tls || kind_.virtual_host;
  settings.endpoint =
      std::string(kind_.tls ? "https" : "http") + "://" + (named ? "localhost:" : "127.0.0.1:") + std::to_string(port_);
  settings.region = kRegion;
  settings.bucket = kBucket;
  settings.prefix = "parts (é) & more/a+b=c~d %41;'*!";
  settings.virtual_host = kind_.virtual_host;
  settings.credentials = {kAccessKey, kSecretKey, kind_.token};
  settings.ca_file = certificate_;
  return settings;
}

json S3Double::control(const std::string& name, const json& value) const {
  httplib::Client client("127.0.0.1", port_);
  const auto answer = client.Post("/-/" + name, value.dump(), "application/json");
  if (!answer || answer->status != 200) throw std::runtime_error("the double of S3 does not understand " + name);
  return json::parse(answer->body);
}

void S3Double::fail(const std::string& method, const std::string& match, const std::string& what,
                    unsigned times) const {
  control("faults", {{{"method", method}, {"match", match}, {"times", times}, {"what", what}}});
}

unsigned S3Double::count(const std::string& method, const std::string& match) const {
  unsigned found = 0;
  for (const json& request : control("log", nullptr)) {
    const auto target = request["target"].get<std::string>();
    if (request["method"] == method && std::regex_search(target, std::regex(match))) ++found;
  }
  return found;
}

}  // namespace meshgauge::server::store
