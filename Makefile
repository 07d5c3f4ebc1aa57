# A thin door to ./dev for fingers that type make.
VERBS := run test build lint container
.PHONY: help $(VERBS)
help:
	@./dev help
$(VERBS):
	@./dev $@
