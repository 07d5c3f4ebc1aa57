#include "server/store/transitions.h"

namespace meshgauge::server::store {

AfterLoss after_hand_back(const Loss& loss, bool excused) {
  const unsigned excuses = loss.excused + (excused ? 1U : 0U);
  if (loss.cancel_requested) return {JobState::cancelled, excuses};
  return {loss.tries >= excuses + kMaxTries ? JobState::failed : JobState::queued, excuses};
}

AfterLoss after_loss(const Loss& loss) {
  const bool suspected = loss.tries > loss.excused + 1;
  return after_hand_back(loss, loss.in_batch && !loss.told_progress && !suspected && loss.excused < kMaxUnbegun);
}

}  // namespace meshgauge::server::store
