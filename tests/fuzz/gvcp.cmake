adit_fuzz(gvcp ROUNDS 5000 DEPENDS adit_sim)
