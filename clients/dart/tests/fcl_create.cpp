// The detector that DART's constraint solver makes by default is oncollide's: a program's own
// FCLCollisionDetector::create() comes before the one of libdart.
#include <dart/collision/CollisionGroup.hpp>
#include <dart/collision/fcl/FCLCollisionDetector.hpp>

#include <oncollide/dart/detector.hpp>

namespace dart::collision {

namespace {

/// Its groups are oncollide's, and call oncollide's detector.
class InPlaceOfFcl final : public FCLCollisionDetector {
public:
    std::shared_ptr<CollisionDetector> cloneWithoutCollisionObjects() const override { return create(); }
    std::unique_ptr<CollisionGroup> createCollisionGroup() override { return detector_->createCollisionGroup(); }

private:
    std::shared_ptr<CollisionDetector> detector_ = OncollideCollisionDetector::create();
};

} // namespace

std::shared_ptr<FCLCollisionDetector> FCLCollisionDetector::create()
{
    return std::make_shared<InPlaceOfFcl>();
}

} // namespace dart::collision
