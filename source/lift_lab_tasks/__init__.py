"""lift_lab_tasks"""
